
% A state that nothing is in yet.
function state = nothing()
    state = $NOTHING;
end

% Functions of <math.h> where MATLAB's own become complex.
function y = real_sqrt(x)
    if x < 0
        y = NaN;
    else
        y = sqrt(x);
    end
end

function y = real_log(x)
    if x < 0
        y = NaN;
    else
        y = log(x);
    end
end

function y = real_log1p(x)
    if x < -1
        y = NaN;
    else
        y = log1p(x);
    end
end

function y = real_pow(x, exponent)
    if x < 0 && exponent ~= fix(exponent)
        y = NaN;
    else
        y = x ^ exponent;
    end
end

function passed = $name_selftest()
% Self-test of $name: golden vectors of hysteron export $VERSION. An error where it fails.
    held_from = $HELD_FROM; % the first last a sample each, those behind them so many:
    hold_for = $HOLD;
//{ inverse
    % References [$OUTPUT_UNIT], and the voltages [$INPUT_UNIT] at their ends that the library puts out.
//}
//{ !inverse
    % Voltages [$INPUT_UNIT], and the displacements [$OUTPUT_UNIT] at their ends that the library puts out.
//}
    given = [ ...
$GIVEN];
    wanted = [ ...
$WANTED];
    tolerance = $TOLERANCE; % 1e-12 of their range
    calls = $name();
    state = calls.rest_at(calls.init(), $REST);
    worst = 0;
    for k = 1:numel(given)
        if k <= held_from
            count = 1;
        else
            count = hold_for;
        end
        for i = 1:count
            [state, y, status] = calls.step(state, given(k));
            if status < 0
                error('$name_selftest:status', 'status %d', status);
            end
        end
        if ~(abs(y - wanted(k)) <= worst)
            worst = abs(y - wanted(k));
        end
    end
    fprintf('golden vectors: %d, largest difference %.2e, allowed %.2e\n', numel(given), worst, tolerance);
    passed = worst <= tolerance;
    if ~passed
        error('$name_selftest:failed', 'FAILED: $name');
    end
    fprintf('PASSED: $name\n');
end

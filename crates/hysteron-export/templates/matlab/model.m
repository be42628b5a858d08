function varargout = $name(varargin)
$DESCRIPTION
%
% No toolbox is needed; MATLAB and GNU Octave both run it. It is the exported C, statement by statement; its
% numbers are in $name_parameters.m, golden vectors in $name_selftest.m.
%
%   displacement = $name(voltage)
%       displacements [$OUTPUT_UNIT] at the ends of the voltages [$INPUT_UNIT], a sample each, from rest (and
%       the hysteresis virgin) at the first. An error where a number is not finite or out of range.
%   [displacement, state, status] = $name(voltage, state)
%       goes on from a state (without one: from rest). status, one a sample: 0; 1 outside of the range that
%       the model was identified in; -1 for a number that is not finite; -2 beyond the range that can be
%       computed with. Below 0 the state is what it was, and the displacement that before.
%   calls = $name()
%       state = calls.init()                                       at rest and virgin at 0
%       [state, displacement, status] = calls.rest_at(state, voltage)
%       [state, displacement, status] = calls.rest_after(state, virgin, voltage)
%                                       driven from `virgin`, where it was virgin, without turning
%       [state, status] = calls.start_at(state, voltage, displacement)
%                                       at rest, with the constant that makes the displacement the one given
%       [state, displacement, status] = calls.step(state, voltage)  one sample
    par = $name_parameters();
    if nargin == 0
        calls.init = @() $name_init(par, nothing());
        calls.rest_at = @(state, voltage) rest_at(par, state, voltage);
        calls.rest_after = @(state, virgin, voltage) rest_after(par, state, virgin, voltage);
        calls.start_at = @(state, voltage, displacement) start_at(par, state, voltage, displacement);
        calls.step = @(state, voltage) step_once(par, state, voltage);
        varargout = {calls};
        return;
    end
    voltage = varargin{1};
    displacement = zeros(size(voltage));
    status = zeros(size(voltage));
    if nargin < 2
        state = $name_init(par, nothing());
        if ~isempty(voltage)
            state = rest_at(par, state, voltage(1));
        end
    else
        state = varargin{2};
    end
    for k = 1:numel(voltage)
        [status(k), state, displacement(k)] = $name_step(par, state, voltage(k), 0);
    end
    if nargout < 3 && any(status(:) < 0)
        at = find(status(:) < 0, 1);
        error('$name:voltage', 'sample %d: a voltage is not finite or out of range (status %d)', ...
            at, status(at));
    end
    varargout = {displacement, state, status};
end

function [state, displacement, status] = rest_at(par, state, voltage)
    [status, state, displacement] = $name_rest_at(par, state, voltage, 0);
end

function [state, displacement, status] = rest_after(par, state, virgin, voltage)
    [status, state, displacement] = $name_rest_after(par, state, virgin, voltage, 0);
end

function [state, status] = start_at(par, state, voltage, displacement)
    [status, state] = $name_start_at(par, state, voltage, displacement);
end

function [state, displacement, status] = step_once(par, state, voltage)
    [status, state, displacement] = $name_step(par, state, voltage, 0);
end

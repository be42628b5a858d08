function varargout = $name(varargin)
$DESCRIPTION
%
% No toolbox is needed; MATLAB and GNU Octave both run it. It is the exported C, statement by statement; its
% numbers are in $name_parameters.m, golden vectors in $name_selftest.m.
%
%   voltage = $name(reference)
%       voltages [$INPUT_UNIT] after which the model's displacement is the reference [$OUTPUT_UNIT], a sample
%       each, from rest at the voltage within the limits that is next to 0. The reference is known $N_PREVIEW
%       samples ahead, beyond its end it stays. An error where a number is not finite or out of range.
%   [voltage, state, status] = $name(reference, state)
%       goes on from a state, sample by sample: here every reference is the newest known, $N_PREVIEW samples
%       ahead. status, one a sample: 0 the model follows; 1 held back by the range, 2 by the slew rate; -1
%       for a number that is not finite, -2 beyond the range that can be computed with. The voltages keep to
%       the limits whatever the status says.
%   calls = $name()
%       state = calls.init()                 at rest and virgin at the voltage within the limits next to 0
%       [state, displacement, status] = calls.rest_at(state, voltage)
%       [state, displacement, status] = calls.rest_after(state, virgin, voltage)
%                                       driven from `virgin`, where it was virgin, without turning
%       [state, status] = calls.measured_at_rest(state, displacement)
%                                       the constant of the displacement, so that there it is the one measured
%       [state, status] = calls.know(state, reference)            the newest reference, without moving
%       [state, voltage, status] = calls.step(state, reference)   one sample
    par = $name_parameters();
    if nargin == 0
        calls.init = @() $name_init(par, nothing());
        calls.rest_at = @(state, voltage) rest_at(par, state, voltage);
        calls.rest_after = @(state, virgin, voltage) rest_after(par, state, virgin, voltage);
        calls.measured_at_rest = @(state, displacement) measured_at_rest(par, state, displacement);
        calls.know = @(state, reference) know(par, state, reference);
        calls.step = @(state, reference) step_once(par, state, reference);
        varargout = {calls};
        return;
    end
    reference = varargin{1};
    newest = reference;
    known = zeros(size(reference)); % what came of those that were known before the first step
    if nargin < 2
        state = $name_init(par, nothing());
        if ~isempty(reference)
            for k = 1:$N_PREVIEW
                at = min(k, numel(reference));
                [state, known(at)] = know(par, state, reference(at));
            end
            newest(:) = reference(min((1:numel(reference)) + $N_PREVIEW, numel(reference)));
        end
    else
        state = varargin{2};
    end
    voltage = zeros(size(reference));
    status = zeros(size(reference));
    for k = 1:numel(reference)
        [status(k), state, voltage(k)] = $name_step(par, state, newest(k), 0);
    end
    status(known < 0) = known(known < 0);
    if nargout < 3 && any(status(:) < 0)
        at = find(status(:) < 0, 1);
        error('$name:reference', 'sample %d: a reference is not finite or out of range (status %d)', ...
            at, status(at));
    end
    varargout = {voltage, state, status};
end

function [state, displacement, status] = rest_at(par, state, voltage)
    [status, state, displacement] = $name_rest_at(par, state, voltage, 0);
end

function [state, displacement, status] = rest_after(par, state, virgin, voltage)
    [status, state, displacement] = $name_rest_after(par, state, virgin, voltage, 0);
end

function [state, status] = measured_at_rest(par, state, displacement)
    [status, state] = $name_measured_at_rest(par, state, displacement);
end

function [state, status] = know(par, state, reference)
    [status, state] = $name_know(par, state, reference);
end

function [state, voltage, status] = step_once(par, state, reference)
    [status, state, voltage] = $name_step(par, state, reference, 0);
end

% Promises of the help of stage.m and stage_inverse.m.
1;
u = 50 + 40 * sin(2 * pi * (0:199) / 100);

% From rest; in pieces; in a column.
whole = stage(u);
assert(size(whole), size(u));
[first, state] = stage(u(1:70));
assert([first, stage(u(71:end), state)], whole);
assert(stage(u')', whole);

% A bad number holds the output where the status is asked for, and is an error where it is not.
[y, state, status] = stage([10 NaN 10 1e300]);
assert(status, [0 -1 0 -2]);
assert(y(2), y(1));
assert(y(4), y(3));
[y, state, status] = stage(200);
assert(status, 1);
try
    stage([10 NaN]);
    error('not refused');
catch problem
    assert(strcmp(problem.identifier, 'stage:voltage'));
end

% Rest and start.
calls = stage();
[state, displacement, status] = calls.rest_at(calls.init(), 30);
assert(status == 0 && abs(stage(30) - displacement) < 1e-9);
[state, displacement] = calls.rest_after(calls.init(), 0, 30);
[state, again] = calls.step(state, 30);
assert(abs(again - displacement) < 1e-9);
[state, status] = calls.start_at(calls.init(), 30, 12.5);
[state, displacement] = calls.step(state, 30);
assert(status == 0 && abs(displacement - 12.5) < 1e-9);

% The inverse: the model behind it follows the reference; within its limits for any number.
par = stage_inverse_parameters();
% (The model takes the voltage for linear between samples, the inverse holds it: half a sample apart.)
reference = 12 + 3 * sin(2 * pi * (0:799) / 4000);
drive = stage_inverse(reference);
follows = stage(drive);
assert(max(abs(follows(400:end) - reference(400:end))) < 0.01);
[drive, state, status] = stage_inverse([12 NaN 1e9 -1e9 Inf 12 * ones(1, 40) NaN]);
assert(status(2) == -1 && any(status > 0) && all(drive >= par.VOLTAGE_LOW & drive <= par.VOLTAGE_HIGH));
assert(all(abs(diff(drive)) <= par.VOLTAGE_STEP + 1e-9));
try
    stage_inverse([12 NaN 12]);
    error('not refused');
catch problem
    assert(strcmp(problem.identifier, 'stage_inverse:reference'));
end
calls = stage_inverse();
state = calls.init();
for k = 1:par.preview
    state = calls.know(state, reference(k));
end
[state, voltage] = calls.step(state, reference(par.preview + 1));
drive = stage_inverse(reference);
assert(voltage, drive(1));
[state, status] = calls.measured_at_rest(calls.rest_at(state, 20), 5);
[state, voltage] = calls.step(state, 5);
assert(status == 0 && abs(voltage - 20) < 1e-6);

stage_selftest();
stage_inverse_selftest();
disp('all promises kept');

"""FMPy's judgement of an exported FMU: fmu.py UNIT.fmu RECORD.csv RATE TOLERANCE (columns t, u, y of the
library; row 0: at rest)."""

import sys

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

path, record, rate, tolerance = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])
t, u, y = np.loadtxt(record, delimiter=",", unpack=True)

problems = validate_fmu(path)
assert not problems, problems

# The whole record, at the model's rate; FMPy hands over inputs by straight lines, at communication points
# exactly.
signals = np.array(list(zip(t, u)), dtype=[("time", float), ("voltage", float)])
result = simulate_fmu(path, start_time=t[0], stop_time=t[-1], step_size=1 / rate, output_interval=1 / rate,
                      input=signals, output=["displacement", "status"], validate=True)
# The displacement at t[k + 1] is that of sample k; at t[0], the one at rest.
assert len(result) == len(t), (len(result), len(t))
first = abs(result["displacement"][0] - y[0])
worst = max(first, np.max(np.abs(result["displacement"][1:] - y[1:])))
assert worst <= tolerance, (worst, tolerance)
assert set(np.unique(result["status"])) == {0}

description = read_model_description(path)
folder = extract(path)
kind = FMU2Slave if description.fmiVersion == "2.0" else FMU3Slave
unit = kind(guid=description.guid, modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder, instanceName="one")
at = {v.name: v.valueReference for v in description.modelVariables}
get = (lambda r: unit.getReal([r])[0]) if kind is FMU2Slave else (lambda r: unit.getFloat64([r])[0])
put = (lambda r, x: unit.setReal([r], [x])) if kind is FMU2Slave else (lambda r, x: unit.setFloat64([r], [x]))
status = lambda: (unit.getInteger if kind is FMU2Slave else unit.getInt32)([at["status"]])[0]
unit.instantiate()


def initialize():
    if kind is FMU2Slave:
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
    else:
        unit.enterInitializationMode(startTime=0.0)
    put(at["voltage"], u[0])
    unit.exitInitializationMode()


def run(first, last):
    out = []
    for k in range(first, last):
        put(at["voltage"], u[k])
        unit.doStep(currentCommunicationPoint=k / rate, communicationStepSize=1 / rate)
        out.append(get(at["displacement"]))
    return np.array(out)


initialize()
whole = run(0, 200)
unit.reset()
initialize()
assert np.array_equal(whole, run(0, 200)), "after a reset it is what it was"

# A saved state, by way of bytes.
saved = unit.getFMUState() if kind is FMU3Slave else unit.getFMUstate()
onwards = run(200, 300)
if kind is FMU2Slave:
    data = unit.serializeFMUstate(saved)
    restored = unit.deSerializeFMUstate(data)
    unit.setFMUstate(restored)
else:
    data = unit.serializeFMUState(saved)
    restored = unit.deserializeFMUState(data)
    unit.setFMUState(restored)
assert np.array_equal(onwards, run(200, 300)), "from a saved state it goes on as it did"
damaged = bytearray(data)
damaged[len(damaged) // 2] ^= 1
try:
    (unit.deSerializeFMUstate if kind is FMU2Slave else unit.deserializeFMUState)(bytes(damaged))
except Exception as refused:
    assert "tatus" in str(refused), refused
else:
    raise AssertionError("damaged bytes are taken for a saved state")

# Numbers that are none: the output holds, the status says so, and nothing is remembered of it.
before = get(at["displacement"])
for bad in (np.nan, np.inf):
    put(at["voltage"], bad)
    unit.doStep(currentCommunicationPoint=300 / rate, communicationStepSize=1 / rate)
    assert get(at["displacement"]) == before and status() == -1
put(at["voltage"], 1000.0)
unit.doStep(currentCommunicationPoint=302 / rate, communicationStepSize=1 / rate)
assert status() == 1, "outside of the range"

# A longer step takes several samples, a shorter one none of its own.
unit.reset()
initialize()
put(at["voltage"], u[1])
unit.doStep(currentCommunicationPoint=0.0, communicationStepSize=5 / rate)
five = get(at["displacement"])
unit.reset()
initialize()
put(at["voltage"], u[1])
for k in range(10):
    unit.doStep(currentCommunicationPoint=k * 0.5 / rate, communicationStepSize=0.5 / rate)
assert get(at["displacement"]) == five

# Parameters.
unit.reset()
initialize()
rest = get(at["displacement"])
offset = get(at["offset"])
put(at["offset"], offset + 2.5)
assert abs(run(0, 1)[0] - rest - 2.5) < 1e-9
unit.reset()
initialize()
assert get(at["offset"]) == offset, "a reset takes the parameters back"
put(at["gain"], 1.5)
assert np.max(np.abs(run(0, 200) - offset - 1.5 * (whole - offset))) < 1e-5 * np.max(np.abs(whole))
unit.reset()
initialize()
put(at["polynomial_1"], 2.0 * get(at["polynomial_1"]))
tuned = run(0, 200)
assert np.max(np.abs(tuned - whole)) > 1.0
unit.terminate()
unit.freeInstance()
units = {v.name: v.unit for v in description.modelVariables}
assert units["voltage"] == "V" and units["displacement"] == "um", units
print(f"FMI {description.fmiVersion}: valid; {len(t)} samples, largest difference {worst:.1e} um, "
      f"allowed {tolerance:.1e} um")

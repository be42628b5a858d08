"""FMPy's judgement of a unit of two axes: fmu_axes.py UNIT.fmu RECORD.csv RATE TOLERANCE (columns: two
inputs, two outputs of the library)."""

import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

path, record, rate, tolerance = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])
table = np.loadtxt(record, delimiter=",")
given, wanted = table[:, :2], table[:, 2:]
problems = validate_fmu(path)
assert not problems, problems
description = read_model_description(path)
old = description.fmiVersion == "2.0"
unit = (FMU2Slave if old else FMU3Slave)(guid=description.guid,
                                         modelIdentifier=description.coSimulation.modelIdentifier,
                                         unzipDirectory=extract(path), instanceName="one")
variables = description.modelVariables
inputs = [v.valueReference for v in variables if v.causality == "input"]
outputs = [v.valueReference for v in variables if v.causality == "output" and v.name != "status"]
status = [v.valueReference for v in variables if v.name == "status"]
get = (lambda: unit.getReal(outputs)) if old else (lambda: unit.getFloat64(outputs))
put = (lambda x: unit.setReal(inputs, x)) if old else (lambda x: unit.setFloat64(inputs, x))
code = lambda: (unit.getInteger if old else unit.getInt32)(status)[0]
unit.instantiate()


def run(first, last):
    out = []
    for k in range(first, last):
        put(list(given[k]))
        unit.doStep(currentCommunicationPoint=k / rate, communicationStepSize=1 / rate)
        out.append(list(get()))
    return np.array(out)


def initialize():
    unit.reset()
    if old:
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()


initialize()
whole = run(0, len(given))
worst = np.max(np.abs(whole - wanted))
assert worst <= tolerance, (worst, tolerance)
initialize()
assert np.array_equal(whole[:200], run(0, 200)), "after a reset it is what it was"
saved = unit.getFMUstate() if old else unit.getFMUState()
onwards = run(200, 300)
data = unit.serializeFMUstate(saved) if old else unit.serializeFMUState(saved)
restored = unit.deSerializeFMUstate(data) if old else unit.deserializeFMUState(data)
unit.setFMUstate(restored) if old else unit.setFMUState(restored)
assert np.array_equal(onwards, run(200, 300)), "from a saved state it goes on as it did"
put([np.nan, 0.0])
unit.doStep(currentCommunicationPoint=300 / rate, communicationStepSize=1 / rate)
assert code() == -1
unit.terminate()
unit.freeInstance()
print(f"FMI {description.fmiVersion}: valid; {len(given)} samples, largest difference {worst:.1e}, "
      f"allowed {tolerance:.1e}")

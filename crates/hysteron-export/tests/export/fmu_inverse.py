"""FMPy's judgement of an exported inverse: fmu_inverse.py UNIT.fmu RECORD.csv RATE TOLERANCE REST LOW HIGH
STEP (columns r, u of the library; nan: not known)."""

import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

path, record = sys.argv[1:3]
rate, tolerance, rest, low, high, step = map(float, sys.argv[3:9])
r, u = np.loadtxt(record, delimiter=",", unpack=True)
problems = validate_fmu(path)
assert not problems, problems
description = read_model_description(path)
old = description.fmiVersion == "2.0"
unit = (FMU2Slave if old else FMU3Slave)(guid=description.guid,
                                         modelIdentifier=description.coSimulation.modelIdentifier,
                                         unzipDirectory=extract(path), instanceName="one")
at = {v.name: v.valueReference for v in description.modelVariables}
get = (lambda n: unit.getReal([at[n]])[0]) if old else (lambda n: unit.getFloat64([at[n]])[0])
put = (lambda n, x: unit.setReal([at[n]], [x])) if old else (lambda n, x: unit.setFloat64([at[n]], [x]))
status = lambda: (unit.getInteger if old else unit.getInt32)([at["status"]])[0]
unit.instantiate()


def initialize():
    put("rest_voltage", rest)
    if old:
        unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    assert get("voltage") == rest


def run(references, first=0):
    out = []
    for k, reference in enumerate(references, first):
        put("reference", reference)
        unit.doStep(currentCommunicationPoint=k / rate, communicationStepSize=1 / rate)
        out.append(get("voltage"))
    return np.array(out)


initialize()
whole = run(r)
worst = np.nanmax(np.abs(whole - u))
assert worst <= tolerance, (worst, tolerance)
unit.reset()
initialize()
assert np.array_equal(whole, run(r)), "after a reset it is what it was"
unit.reset()
initialize()
wild = r.copy()
wild[::7] = np.nan
wild[3::11] = np.inf
wild[5::13] = 1e300
driven = run(wild)
within = np.all((driven >= low) & (driven <= high)) and np.max(np.abs(np.diff(driven))) <= step * (1 + 1e-5)
assert within, "within the limits"
run([np.nan], len(r))
assert status() == -1
units = {v.name: v.unit for v in description.modelVariables}
assert units["reference"] == "um" and units["voltage"] == "V" and units["displacement"] == "um", units
unit.terminate()
unit.freeInstance()
print(f"FMI {description.fmiVersion}: valid; {len(r)} samples, largest difference {worst:.1e} V, "
      f"allowed {tolerance:.1e} V")

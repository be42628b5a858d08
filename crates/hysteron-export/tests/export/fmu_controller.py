"""FMPy's judgement of an exported controller: fmu_controller.py UNIT.fmu RECORD.csv RATE TOLERANCE REST
MEASURED LOW HIGH PREVIEW (columns reference, voltage, reading of the library); loop.csv: reference and
voltage of a loop with the model of the unit beside it."""

import sys

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

path, record = sys.argv[1:3]
rate, tolerance, rest, measured, low, high, preview = map(float, sys.argv[3:10])
r, u, y = np.loadtxt(record, delimiter=",", unpack=True)
problems = validate_fmu(path)
assert not problems, problems
description = read_model_description(path)
old = description.fmiVersion == "2.0"


class Unit:
    """One instance of an FMU."""

    def __init__(self, path):
        own = read_model_description(path)
        self.own = (FMU2Slave if old else FMU3Slave)(guid=own.guid, unzipDirectory=extract(path),
                                                     modelIdentifier=own.coSimulation.modelIdentifier,
                                                     instanceName="one")
        self.at = {v.name: v.valueReference for v in own.modelVariables}
        self.own.instantiate()

    def get(self, name):
        return (self.own.getReal if old else self.own.getFloat64)([self.at[name]])[0]

    def put(self, name, x):
        (self.own.setReal if old else self.own.setFloat64)([self.at[name]], [x])

    def initialize(self):
        if old:
            self.own.setupExperiment(startTime=0.0)
        self.own.enterInitializationMode()
        self.own.exitInitializationMode()

    def step(self, k):
        self.own.doStep(currentCommunicationPoint=k / rate, communicationStepSize=1 / rate)

    def status(self):
        return (self.own.getInteger if old else self.own.getInt32)([self.at["status"]])[0]

    def end(self):
        self.own.terminate()
        self.own.freeInstance()


controller = Unit(path)
unit = controller.own


def initialize(gain=1.0):
    offset = controller.get("offset")
    controller.put("gain", gain)
    controller.put("rest_voltage", rest)
    controller.put("reading", offset + gain * (measured - offset))
    controller.initialize()
    assert controller.get("voltage") == rest


def period(k, reading, reference):
    controller.put("reading", reading)
    controller.put("reference", reference)
    controller.step(k)
    return controller.get("voltage")


# The reference of a step is one sample more ahead than its voltage looks: the reading is that of its
# beginning, the voltage that of the period behind it.
ahead = lambda k: r[min(k + 1 + int(preview), len(r) - 1)]
replay = lambda first=0, last=len(r): np.array([period(k, y[k], ahead(k)) for k in range(first, last)])

initialize()
whole = replay()
worst = np.max(np.abs(whole[:-1] - u[1:]))
assert worst <= tolerance, (worst, tolerance)
unit.reset()
initialize()
assert np.array_equal(whole, replay()), "after a reset it is what it was"

# A saved state, by way of bytes.
unit.reset()
initialize()
replay(0, 300)
saved = unit.getFMUstate() if old else unit.getFMUState()
onwards = replay(300, 400)
data = unit.serializeFMUstate(saved) if old else unit.serializeFMUState(saved)
restored = unit.deSerializeFMUstate(data) if old else unit.deserializeFMUState(data)
unit.setFMUstate(restored) if old else unit.setFMUState(restored)
assert np.array_equal(onwards, replay(300, 400)), "from a saved state it goes on as it did"

# In a loop with the model's own unit, both stepped beside each other.
looped = 0.0
if tolerance < 1e-6:
    r, u = np.loadtxt("loop.csv", delimiter=",", unpack=True)
    plant = Unit(path.replace("_controller", ""))
    unit.reset()
    initialize()
    plant.put("voltage", rest)
    plant.initialize()
    zero = plant.get("displacement") - measured
    voltage = rest
    for k in range(len(r) - 1):
        reading = plant.get("displacement") - zero
        plant.put("voltage", voltage)
        plant.step(k)
        voltage = period(k, reading, ahead(k))
        looped = max(looped, abs(voltage - u[k + 1]))
    plant.end()
    assert looped <= tolerance, (looped, tolerance)
    r, u, y = np.loadtxt(record, delimiter=",", unpack=True)

# A stage that moves twice as far, trimmed to it.
unit.reset()
offset = controller.get("offset")
initialize(2.0)
twice = lambda x: offset + 2.0 * (x - offset)
doubled = np.array([period(k, twice(y[k]), twice(ahead(k))) for k in range(len(r))])
assert np.max(np.abs(doubled - whole)) <= 2.0 * tolerance, np.max(np.abs(doubled - whole))

# Numbers that are none.
unit.reset()
initialize()
wild, read = r.copy(), y.copy()
wild[::7] = np.nan
wild[3::11] = np.inf
read[5::13] = 1e300
read[::17] = np.nan
driven = np.array([period(k, read[k], wild[k]) for k in range(len(r))])
assert np.all((driven >= low) & (driven <= high)), "within the limits"
period(len(r), np.nan, r[0])
assert controller.status() == -1
units = {v.name: v.unit for v in description.modelVariables}
assert units["voltage"] == "V", units
assert units["reference"] == units["reading"] == units["displacement"] == "um", units
controller.end()
print(f"FMI {description.fmiVersion}: valid; {len(r)} samples, largest difference {worst:.1e} V, in a loop "
      f"{looped:.1e} V, allowed {tolerance:.1e} V")

"""TDMS files of all variants that are read, and what npTDMS reads from them.

python tdms.py FOLDER writes the files and FOLDER/expected.json. `TdmsWriter` writes what it can; segments
that it does not write
(interleaved, big-endian, several chunks, interrupted) are put together here byte by byte and still read by
npTDMS.
"""

import logging
import struct
import sys
from fractions import Fraction
from pathlib import Path

import expected

try:
    import numpy as np
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter
    from nptdms.timestamp import TimestampArray
except ImportError as missing:
    expected.skip(missing)

logging.disable()
folder = Path(sys.argv[1])
random = np.random.default_rng(18)
TYPES = ["int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64"]
CODES = {
    "int8": 1,
    "int16": 2,
    "int32": 3,
    "int64": 4,
    "uint8": 5,
    "uint16": 6,
    "uint32": 7,
    "uint64": 8,
    "float32": 9,
    "float64": 10,
    "bool": 0x21,
}


def numbers(kind, count):
    """Numbers of a type, its extremes among them."""
    if kind == "bool":
        return random.integers(0, 2, count).astype(bool)
    if kind.startswith("float"):
        return random.normal(size=count).astype(kind)
    limits = np.iinfo(kind)
    values = random.integers(limits.min, limits.max, count, dtype=kind, endpoint=True)
    values[:2] = limits.min, limits.max
    return values


# --- Segments, byte by byte -----------------------------------------------------------------------


def text(order, string):
    raw = string.encode()
    return struct.pack(order + "I", len(raw)) + raw


def properties(order, entries):
    out = struct.pack(order + "I", len(entries))
    for name, value in entries.items():
        out += text(order, name)
        if isinstance(value, str):
            out += struct.pack(order + "I", 0x20) + text(order, value)
        elif isinstance(value, int):
            out += struct.pack(order + "II", 7, value)
        else:
            out += struct.pack(order + "Id", 10, value)
    return out


def values_index(order, kind, count):
    return struct.pack(order + "IIIQ", 20, CODES[kind], 1, count)


SAME = "same"


def segment(
    objects, chunks, *, big=False, interleaved=False, new_list=True, metadata=True, length=None, version=4713
):
    """objects: (path, index bytes, SAME or None, properties); chunks: lists of arrays, one a channel."""
    order = ">" if big else "<"
    meta = b""
    if metadata:
        meta = struct.pack(order + "I", len(objects))
        for path, index, entries in objects:
            meta += text(order, path)
            meta += (
                struct.pack(order + "I", 0xFFFFFFFF)
                if index is None
                else b"\0\0\0\0"
                if index == SAME
                else index
            )
            meta += properties(order, entries)
    raw = b""
    for chunk in chunks:
        arrays = [np.asarray(a).astype(np.asarray(a).dtype.newbyteorder(order)) for a in chunk]
        if interleaved:
            raw += b"".join(a[i : i + 1].tobytes() for i in range(len(arrays[0])) for a in arrays)
        else:
            raw += b"".join(a.tobytes() for a in arrays)
    flags = (
        (metadata << 1) | ((new_list and metadata) << 2) | (bool(raw) << 3) | (interleaved << 5) | (big << 6)
    )
    total = len(meta) + len(raw) if length is None else length
    return (
        b"TDSm"
        + struct.pack("<I", flags)
        + struct.pack(order + "IQQ", version, total, len(meta))
        + meta
        + raw
    )


U, Y = "/'rig'/'u_V'", "/'rig'/'y_um'"


def two(kinds, count, order="<", u=None, y=None):
    return [
        (U, values_index(order, kinds[0], count), u or {}),
        (Y, values_index(order, kinds[1], count), y or {}),
    ]


def linear(i, slope, intercept, source=0xFFFFFFFF):
    pre = f"NI_Scale[{i}]_"
    return {
        pre + "Scale_Type": "Linear",
        pre + "Linear_Slope": slope,
        pre + "Linear_Y_Intercept": intercept,
        pre + "Linear_Input_Source": source,
    }


def polynomial(i, coefficients, source=0xFFFFFFFF):
    pre = f"NI_Scale[{i}]_"
    entries = {
        pre + "Scale_Type": "Polynomial",
        pre + "Polynomial_Coefficients_Size": len(coefficients),
        pre + "Polynomial_Input_Source": source,
    }
    return entries | {f"{pre}Polynomial_Coefficients[{k}]": c for k, c in enumerate(coefficients)}


files = {}
for big in (False, True):
    order, name = (">", "big") if big else ("<", "little")
    for kind in TYPES + ["bool"]:
        for interleaved in (False, True):
            chunk = lambda n: [numbers(kind, n), numbers("float64", n)]
            one = segment(two((kind, "float64"), 40, order), [chunk(40)], big=big, interleaved=interleaved)
            several = segment(
                [(U, SAME, {}), (Y, SAME, {})],
                [chunk(40) for _ in range(3)],
                big=big,
                interleaved=interleaved,
            )
            plain = segment([], [chunk(40)] * 2, big=big, interleaved=interleaved, metadata=False)
            layout = "interleaved" if interleaved else "contiguous"
            files[f"{name}_{kind}_{layout}"] = one + several + plain
    # Metadata that add to those before: a longer chunk of one channel, then another channel, then no data of
    # one.
    first = segment(
        two(("int16", "float32"), 30, order), [[numbers("int16", 30), numbers("float32", 30)]], big=big
    )
    longer = segment(
        [(U, values_index(order, "int16", 50), {}), (Y, values_index(order, "float32", 50), {"a": "b"})],
        [[numbers("int16", 50), numbers("float32", 50)]],
        big=big,
        new_list=False,
    )
    third = ("/'rig'/'T_K'", values_index(order, "float64", 80), {})
    more = segment(
        [third],
        [[numbers("int16", 50), numbers("float32", 50), numbers("float64", 80)]],
        big=big,
        new_list=False,
    )
    none = segment(
        [("/'rig'/'T_K'", None, {})],
        [[numbers("int16", 50), numbers("float32", 50)]] * 2,
        big=big,
        new_list=False,
    )
    files[f"{name}_incremental"] = first + longer + more + none
    # A new list of objects leaves the others out; "as before" reaches over it.
    alone = segment([(Y, values_index(order, "float32", 20), {})], [[numbers("float32", 20)]], big=big)
    back = segment([(U, SAME, {}), (Y, SAME, {})], [[numbers("int16", 30), numbers("float32", 20)]], big=big)
    files[f"{name}_new_list"] = first + alone + back
    scaled = two(
        ("int16", "int32"), 60, order, u=linear(0, 3.05e-4, 0.125), y=polynomial(0, [1.5, -2e-3, 3e-7, 1e-12])
    )
    files[f"{name}_scaled"] = segment(scaled, [[numbers("int16", 60), numbers("int32", 60)]], big=big)
    chain = linear(0, 3.05e-4, 0.125) | polynomial(1, [0.1, 2.0, -0.3], 0) | linear(2, 1e-3, 5.0, 1)
    files[f"{name}_chain"] = segment(
        two(("int16", "float64"), 60, order, u=chain | {"NI_Number_Of_Scales": 3}),
        [[numbers("int16", 60), numbers("float64", 60)]],
        big=big,
    )
    done = linear(0, 2.0, 1.0) | {"NI_Scaling_Status": "scaled", "NI_Number_Of_Scales": 1}
    files[f"{name}_already_scaled"] = segment(
        two(("float64", "float64"), 9, order, u=done), [[numbers("float64", 9)] * 2], big=big
    )
    group = [("/'rig'", None, linear(0, 0.5, -1.0)), *two(("int16", "int16"), 25, order)]
    files[f"{name}_scaled_by_group"] = segment(group, [[numbers("int16", 25), numbers("int16", 25)]], big=big)
    wave = {"wf_increment": 2e-4, "wf_start_offset": 0.0, "wf_samples": 70, "unit_string": "V"}
    names = [
        ("/'rig'/'drive'", values_index(order, "float64", 70), wave),
        ("/'rig'/'sensor'", values_index(order, "float64", 70), wave | {"unit_string": "µm"}),
    ]
    files[f"{name}_waveform"] = segment(names, [[numbers("float64", 70), numbers("float64", 70)]], big=big)
    # The last segment: its length unknown, whole or cut off.
    begun = segment(
        two(("int32", "float64"), 30, order), [[numbers("int32", 30), numbers("float64", 30)]], big=big
    )
    for interleaved in (False, True):
        layout = "interleaved" if interleaved else "contiguous"
        data = [[numbers("int32", 30), numbers("float64", 30)] for _ in range(3)]
        last = segment(
            two(("int32", "float64"), 30, order),
            data,
            big=big,
            interleaved=interleaved,
            length=0xFFFFFFFFFFFFFFFF,
        )
        files[f"{name}_{layout}_unknown_length"] = begun + last
        for cut in (1, 100, 200, 300, 361, 700):
            files[f"{name}_{layout}_cut_{cut}"] = begun + last[:-cut]
    files[f"{name}_cut_in_lead_in"] = begun + last[:20]
    files[f"{name}_shorter_last_chunk"] = segment(
        two(("float64", "float64"), 30, order),
        [[numbers("float64", 30), numbers("float64", 30)], [numbers("float64", 12), numbers("float64", 12)]],
        big=big,
    )

for name, data in files.items():
    (folder / f"{name}.tdms").write_bytes(data)

# --- What TdmsWriter writes -----------------------------------------------------------------------


def write(name, *segments, version=4712):
    with TdmsWriter(folder / f"{name}.tdms", version=version) as writer:
        for objects in segments:
            writer.write_segment(objects)


for version in (4712, 4713):
    for kind in TYPES + ["bool"]:
        pair = lambda: [
            ChannelObject("rig", "u_V", numbers(kind, 50)),
            ChannelObject("rig", "y_um", numbers("float64", 50)),
        ]
        write(f"writer_{version}_{kind}", pair(), pair(), version=version)
stamps = np.datetime64("2024-02-29T12:00:00.25", "us") + np.arange(80) * np.timedelta64(125, "us")
root = RootObject({"name": "loop", "made": np.datetime64("2024-02-29T12:00:00"), "runs": 3})
group = GroupObject("rig", {"operator": "text of ünïcode", "gain": 2.5, "on": True})
write(
    "writer_timestamps",
    [
        root,
        group,
        ChannelObject("rig", "Time", stamps),
        ChannelObject("rig", "u_V", numbers("float64", 80)),
        ChannelObject("rig", "y_um", numbers("float32", 80)),
    ],
)
write(
    "writer_texts",
    [
        ChannelObject("rig", "note", ["a", "bc", "", "üü"] * 5),
        ChannelObject("rig", "u_V", numbers("float64", 20)),
        ChannelObject("rig", "y_um", numbers("int16", 20)),
    ],
)
write(
    "writer_groups",
    [
        ChannelObject("drive", "u_V", numbers("float64", 33)),
        ChannelObject("sensor's", "y_um", numbers("float64", 33)),
    ],
)
write(
    "writer_incremental",
    [ChannelObject("rig", "u_V", numbers("float64", 10)), ChannelObject("rig", "y_um", numbers("int8", 10))],
    [
        ChannelObject("rig", "u_V", numbers("float64", 10), {"unit_string": "V"}),
        ChannelObject("rig", "y_um", numbers("int8", 10)),
    ],
    [ChannelObject("rig", "y_um", numbers("int8", 7)), ChannelObject("rig", "u_V", numbers("float64", 7))],
)


def seconds(channel):
    """Timestamps as seconds since the first, exact but for the last rounding."""
    units = [int(s) * 2**64 + int(f) for s, f in zip(channel["seconds"], channel["second_fractions"])]
    return [float(Fraction(unit - units[0], 2**64)) for unit in units]


cases = []
for path in sorted(folder.glob("*.tdms")):
    columns = []
    file = TdmsFile.read(path, raw_timestamps=True)
    shortest = min(len(channel) for group in file.groups() for channel in group.channels())
    for group in file.groups():
        for channel in group.channels():
            data = channel[:]
            if isinstance(data, TimestampArray):
                data = seconds(data)
            elif data.dtype == object:
                continue
            increment = channel.properties.get("wf_increment")
            if "cut" in path.name:
                # The reader takes as many samples as all channels have.
                data = data[:shortest]
            columns.append(
                expected.column(
                    f"{group.name}/{channel.name}",
                    data,
                    unit=channel.properties.get("unit_string"),
                    sample_rate_hz=increment and 1 / increment,
                )
            )
    cases.append({"file": path.name, "columns": columns})
expected.write(folder, cases)

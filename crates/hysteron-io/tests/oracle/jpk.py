"""What afmformats reads from the JPK archives of its source distribution, and from those archives written
anew in other ways.

python jpk.py FOLDER has pip download the source distribution of the installed version (or takes that of
AFMFORMATS_SOURCE), unpacks its archives into FOLDER, writes the others beside them, and FOLDER/expected.json.
"""

import importlib.metadata
import os
import subprocess
import sys
import tarfile
from pathlib import Path

import expected

try:
    import archives
    import numpy as np
    from afmformats.errors import MissingMetaDataError
    from afmformats.formats.fmt_jpk import jpk_data
    from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache, JPKReader
except ImportError as missing:
    expected.skip(missing)

folder = Path(sys.argv[1])
source = os.environ.get("AFMFORMATS_SOURCE")
if source is None:
    version = importlib.metadata.version("afmformats")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", "afmformats"]
    done = subprocess.run([*command, "--dest", str(folder), f"afmformats=={version}"], capture_output=True)
    if done.returncode:
        expected.skip("pip cannot download the source distribution of afmformats")
    source = next(folder.glob("*.tar.gz"))
with tarfile.open(source) as archive:
    for member in archive.getmembers():
        path = Path(member.name)
        if path.suffix.startswith(".jpk-") and member.isfile():
            (folder / path.name).write_bytes(archive.extractfile(member).read())


random = np.random.default_rng(18)


def in_unit(reader, properties, name, file, slot):
    """A channel in a unit of its list, and that unit."""
    with ArchiveCache.get(reader.path).open(file) as data:
        try:
            values, unit, _ = jpk_data.load_dat_unit(data, name=name, properties=properties, slot=slot)
        except KeyError:
            if slot != "default":
                return None, None
            # afmformats does not convert channels that are shown as they are stored.
            data.seek(0)
            values, unit = jpk_data.load_dat_raw(data, name=name, properties=properties), None
    return values, unit


def slots(properties, name):
    """Units of a channel besides the one that is shown."""
    conversions = f"channel.{name}.conversion-set.conversions"
    shown = properties.get(f"{conversions}.default", properties.get(f"{conversions}.base"))
    listed = [*str(properties.get(f"{conversions}.list", "")).split(), properties.get(f"{conversions}.base")]
    return [slot for slot in dict.fromkeys(listed) if slot not in (None, shown)]


def times(reader, index, segments, columns):
    """Times of a curve whose segments have rates of their own."""
    try:
        values = np.concatenate([reader.get_data("time", index, segment) for segment in segments])
    except (MissingMetaDataError, KeyError, ValueError):
        # afmformats gives no times without what it needs for forces, and of curves of a kind that it knows.
        return
    columns.append(expected.column(f"{reader.get_index_path(index)}time", values, unit="s"))


def columns_of(path, most):
    """Columns of all curves, at most so many of each kind."""
    reader = JPKReader(path)
    of_segments, of_units, of_curves, of_times = [], [], [], []
    for index in range(len(reader)):
        curve = reader.get_index_path(index)
        segments = reader.get_index_segment_numbers(index)
        parts, rates = {}, []
        for segment in segments:
            where = reader.get_index_segment_path(index, segment)
            properties = reader._get_index_segment_properties(index, segment)
            duration = properties.get("force-segment-header.duration")
            samples = []
            for file in reader.files:
                if file.startswith(where) and file.endswith(".dat"):
                    name = Path(file).stem
                    try:
                        values, unit = in_unit(reader, properties, name, file, "default")
                    except jpk_data.ReadJPKError:
                        # Floats, which afmformats does not read.
                        continue
                    samples.append(len(values))
                    rate = len(values) / duration if duration else None
                    parts.setdefault(name, []).append(values)
                    of_segments.append(expected.column(f"{where}{name}", values, unit, rate))
                    for slot in slots(properties, name):
                        others, unit = in_unit(reader, properties, name, file, slot)
                        if others is not None:
                            of_units.append(expected.column(f"{where}{name}:{slot}", others, unit, rate))
            rates.append(max(samples) / duration if samples and duration else None)
        for name, values in parts.items():
            if 1 < len(segments) == len(values):
                of_curves.append(expected.column(f"{curve}{name}", np.concatenate(values)))
        if len(rates) > 1 and None not in rates and max(rates) / min(rates) - 1 > 1e-6:
            times(reader, index, segments, of_times)
    kinds = (of_segments, of_units, of_curves, of_times)
    return [column for kind in kinds for column in some(kind, most)]


def some(columns, most):
    if len(columns) <= most:
        return columns
    return [columns[i] for i in sorted(random.choice(len(columns), most, replace=False))]


cases = []
originals = sorted(folder.glob("*.jpk-*"))
for path in originals:
    cases.append({"file": path.name, "columns": columns_of(path, 30)})
for path in originals:
    for kind, change, how in archives.variants(random):
        archive = archives.Archive(path, JPKReader(path))
        change(archive)
        other = folder / f"{path.stem}_{kind}{path.suffix}"
        archive.write(other, **how)
        columns = columns_of(other, 4)
        assert columns, other
        cases.append({"file": other.name, "columns": columns})
expected.write(folder, cases)

"""What afmformats reads from the JPK archives of its source distribution.

python jpk.py FOLDER has pip download the source distribution of the installed version (or takes that of
AFMFORMATS_SOURCE), unpacks its archives into FOLDER and writes FOLDER/expected.json.
"""

import importlib.metadata
import os
import subprocess
import sys
import tarfile
from pathlib import Path

import expected

try:
    import numpy as np
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


def default(reader, index, segment, name, file):
    """A channel in the unit that the file shows by default."""
    properties = reader._get_index_segment_properties(index, segment)
    with ArchiveCache.get(reader.path).open(file) as data:
        try:
            values, unit, _ = jpk_data.load_dat_unit(data, name=name, properties=properties)
        except KeyError:
            # afmformats does not convert channels that are shown as they are stored.
            data.seek(0)
            values, unit = jpk_data.load_dat_raw(data, name=name, properties=properties), None
    return values, unit


cases = []
for path in sorted(folder.glob("*.jpk-*")):
    reader = JPKReader(path)
    columns = []
    for index in range(len(reader)):
        curve = reader.get_index_path(index)
        segments = reader.get_index_segment_numbers(index)
        parts = {}
        for segment in segments:
            where = reader.get_index_segment_path(index, segment)
            for file in reader.files:
                if file.startswith(where) and file.endswith(".dat"):
                    name = Path(file).stem
                    try:
                        values, unit = default(reader, index, segment, name, file)
                    except jpk_data.ReadJPKError:
                        # Floats, which afmformats does not read.
                        continue
                    parts.setdefault(name, []).append(values)
                    columns.append(expected.column(f"{where}{name}", values, unit=unit))
        for name, values in parts.items():
            if 1 < len(segments) == len(values):
                columns.append(expected.column(f"{curve}{name}", np.concatenate(values)))
    cases.append({"file": path.name, "columns": columns})
expected.write(folder, cases)

"""Archives of JPK written anew: the same curves, stored, scaled, cut and spelled in other ways."""

import re
import zipfile
from pathlib import PurePosixPath

import numpy as np

#: Types of integers that afmformats reads, and how they stand in a file.
ENCODINGS = {
    "signedshort": ">i2",
    "unsignedshort": ">u2",
    "signedinteger": ">i4",
    "unsignedinteger": ">u4",
    "signedlong": ">i8",
}
HEADERS = ("header.properties", "segment-header.properties")
#: Most samples of a channel, and curves of a map, that are kept.
SAMPLES, CURVES = 150, 3


class Archive:
    """Entries by name, `None` for a folder, as they stand in the file."""

    def __init__(self, path, reader):
        with zipfile.ZipFile(path) as archive:
            self.entries = {
                info.filename: None if info.is_dir() else archive.read(info) for info in archive.infolist()
            }
        #: Type of the integers of each array; that of others is none of afmformats'.
        self.encodings = {}
        numbers = reader.get_index_numbers()
        for index in range(len(reader)):
            for segment in reader.get_index_segment_numbers(index):
                where = reader.get_index_segment_path(index, segment)
                known = reader._get_index_segment_properties(index, segment)
                for name in self.arrays(where):
                    channel = PurePosixPath(name).stem
                    keys = [f"channel.{channel}.{front}encoder.type" for front in ("data.", "")]
                    self.encodings[name] = next((known[key] for key in keys if key in known), None)
        for number in numbers[CURVES:]:
            self.drop(f"index/{number}/")
        self.cut(dict.fromkeys(self.segments(), SAMPLES))

    def arrays(self, where=""):
        return [name for name in self.entries if name.startswith(where) and name.endswith(".dat")]

    def segments(self):
        """Folders of all segments."""
        return [name for name in self.entries if re.fullmatch(r"(index/\d+/)?segments/\d+/", name)]

    def drop(self, where):
        self.entries = {name: data for name, data in self.entries.items() if not name.startswith(where)}

    def copy(self, where, to):
        for name, data in list(self.entries.items()):
            if name.startswith(where):
                other = to + name[len(where) :]
                self.entries[other] = data
                if name in self.encodings:
                    self.encodings[other] = self.encodings[name]

    def size(self, name):
        """Bytes of a number of an array; of those that afmformats does not read, 4."""
        return np.dtype(ENCODINGS.get(self.encodings.get(name), ">f4")).itemsize

    def cut(self, lengths):
        """Segments with no more samples than these."""
        for segment, length in lengths.items():
            counts = []
            for name in self.arrays(segment):
                self.entries[name] = self.entries[name][: length * self.size(name)]
                counts.append(len(self.entries[name]) // self.size(name))
            self.set(segment, "num-points", max(counts, default=0))

    def set(self, segment, key, value):
        """A property of a segment made anew."""
        name = segment + "segment-header.properties"
        text = self.entries[name].decode("latin-1")
        text = re.sub(rf"(?m)^(force-segment-header\.{key})=.*$", rf"\g<1>={value}", text)
        self.entries[name] = text.encode("latin-1")

    def map_properties(self, change):
        """Lists of properties with their lines changed."""
        for name, data in self.entries.items():
            if name.endswith(HEADERS):
                lines = data.decode("latin-1").splitlines()
                self.entries[name] = "\n".join(change(line) for line in lines).encode("latin-1") + b"\n"

    def write(self, path, method=zipfile.ZIP_DEFLATED, backwards=False):
        names = sorted(self.entries, reverse=backwards)
        with zipfile.ZipFile(path, "w", method) as archive:
            for name in names:
                data = self.entries[name]
                archive.writestr(zipfile.ZipInfo(name), b"") if data is None else archive.writestr(name, data)


def replaced(pattern, new):
    """A change of lines: the value of each property that matches, made anew."""
    found = re.compile(rf"({pattern})=(.*)")

    def change(line):
        match = found.fullmatch(line)
        return f"{match[1]}={new(match[match.lastindex])}" if match else line

    return change


def encoded(archive, encoding, random):
    """The integers in another type, over its whole range."""
    info = np.iinfo(ENCODINGS[encoding])
    for name in archive.arrays():
        if archive.encodings.get(name) in ENCODINGS:
            count = len(archive.entries[name]) // archive.size(name)
            values = random.integers(
                info.min, info.max, count, dtype=info.dtype.newbyteorder("="), endpoint=True
            )
            archive.entries[name] = values.astype(ENCODINGS[encoding]).tobytes()
            archive.encodings[name] = encoding
    archive.map_properties(replaced(r".*encoder\.type", lambda old: encoding if old in ENCODINGS else old))


def scaled(archive, random):
    """Other multipliers and offsets, in several spellings."""
    spell = [repr, "{:.3e}".format, "{:.17g}".format, "{:+.5f}".format, lambda x: str(int(100 * x))]
    number = lambda _: spell[random.integers(len(spell))](float(random.normal(scale=3) or 1.0))
    archive.map_properties(replaced(r".*scaling\.(?:multiplier|offset)", number))


def shown_as(archive, place):
    """Another unit by default: the base, or the first of the list."""
    slots = {}

    def note(line):
        match = re.fullmatch(r"(.*conversions)\.(list|base)=(.*)", line)
        if match and match[3].split():
            slots[match[1], match[2]] = match[3].split()[0]
        return line

    def change(line):
        match = re.fullmatch(r"(.*conversions)\.default=.*", line)
        new = match and slots.get((match[1], place))
        return f"{match[1]}.default={new}" if new else line

    archive.map_properties(note)
    archive.map_properties(change)


def cut_short(archive, random):
    """Segments of other lengths, and of durations that give each a rate."""
    segments = archive.segments()
    archive.cut(dict(zip(segments, random.permutation(np.arange(2, 60))[: len(segments)].tolist())))
    for segment in archive.segments():
        archive.set(segment, "duration", repr(float(random.uniform(0.01, 3))))


def repeated(archive):
    """A curve of twice as many segments."""
    for curve in sorted({segment.split("segments/")[0] for segment in archive.segments()}):
        own = [segment for segment in archive.segments() if segment.startswith(f"{curve}segments/")]
        for number, segment in enumerate(own):
            archive.copy(segment, f"{curve}segments/{len(own) + number}/")


def first_segment(archive):
    for segment in archive.segments():
        if not segment.endswith("segments/0/"):
            archive.drop(segment)


def without_first_curve(archive):
    curves = sorted(name for name in archive.entries if re.fullmatch(r"index/\d+/", name))
    if len(curves) > 1:
        archive.drop(curves[0])


def spelled(archive, how):
    """Properties in other spellings of the same format."""

    def change(line):
        if line.startswith("#") or "=" not in line:
            return line + "\r"
        key, value = line.split("=", 1)
        if how == "spaces":
            return f"   {key} = {value}\r"
        if how == "colons":
            return f"{key}:{value}\n! a remark = 1\n"
        # jprops, with which afmformats reads them, takes an escaped t for a tab.
        if how == "escapes" and key[-1] not in "tnrf":
            return f"{key[:-1]}\\u{ord(key[-1]):04x}={value}"
        continued = how == "continued" and value and value[0] not in " \\"
        return f"{key}=\\\n    {value}" if continued else line

    archive.map_properties(change)


def plain_units(archive):
    """Units without their type, as older programs write them."""
    archive.map_properties(lambda line: re.sub(r"scaling\.unit\.unit=", "scaling.unit=", line))


def variants(random):
    """Names of the ways, what each changes, and how it is written."""
    for encoding in ENCODINGS:
        yield encoding, lambda archive, encoding=encoding: encoded(archive, encoding, random), {}
    yield "scaled", lambda archive: scaled(archive, random), {}
    yield "base", lambda archive: shown_as(archive, "base"), {}
    yield "first", lambda archive: shown_as(archive, "list"), {}
    yield "lengths", lambda archive: cut_short(archive, random), {}
    yield "repeated", repeated, {"method": zipfile.ZIP_STORED}
    yield "segment", first_segment, {"backwards": True}
    yield "curve", without_first_curve, {}
    for how in ("spaces", "colons", "escapes", "continued"):
        yield how, lambda archive, how=how: spelled(archive, how), {}
    yield "units", plain_units, {"method": zipfile.ZIP_STORED, "backwards": True}

    def all_of_them(archive):
        encoded(archive, "signedinteger", random)
        scaled(archive, random)
        shown_as(archive, "list")
        cut_short(archive, random)
        spelled(archive, "spaces")

    yield "all", all_of_them, {}

"""Readers of image files written from the formats' specifications, for tests of files that a library wrote."""

import struct
import zlib

import numpy


def read_png(path):
    """(array [y, x, channel], list of chunk types). PNG specification (ISO 15948), no interlace."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, packed, at = [], b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0] == zlib.crc32(kind + body)
        chunks.append(kind.decode())
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert interlace == 0
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    step = channels * depth // 8
    stride = width * step
    raw = zlib.decompress(packed)
    rows, above = [], bytes(stride)
    for y in range(height):
        filtered = raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)]
        above = unfilter(raw[y * (stride + 1)], filtered, above, step)
        rows.append(above)
    values = numpy.frombuffer(b"".join(rows), dtype=">u2" if depth == 16 else "u1")
    return values.reshape(height, width, channels).astype(int), chunks


def unfilter(kind, filtered, above, step):
    row = bytearray(filtered)
    for i, value in enumerate(filtered):
        left = row[i - step] if i >= step else 0
        up = above[i]
        corner = above[i - step] if i >= step else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        elif kind == 4:
            p = left + up - corner
            guess = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))[2]
        else:
            guess = 0
        row[i] = (value + guess) & 255
    return bytes(row)


def read_tiff(path):
    """Array [y, x, channel] of an uncompressed, contiguous TIFF 6.0 file."""
    data = path.read_bytes()
    order = {b"II": "<", b"MM": ">"}[data[:2]]
    at = struct.unpack(order + "I", data[4:8])[0]
    tags = {}
    for i in range(struct.unpack(order + "H", data[at:at + 2])[0]):
        tag, kind, count = struct.unpack(order + "HHI", data[at + 2 + 12 * i:at + 10 + 12 * i])
        if kind not in (3, 4):
            continue
        letter, size = {3: ("H", 2), 4: ("I", 4)}[kind]
        place = at + 10 + 12 * i
        if count * size > 4:
            place = struct.unpack(order + "I", data[place:place + 4])[0]
        tags[tag] = struct.unpack(f"{order}{count}{letter}", data[place:place + count * size])
    assert tags.get(259, (1,)) == (1,), "compressed"
    assert tags.get(284, (1,)) == (1,), "planes"
    bits, form = tags[258][0], tags.get(339, (1,))[0]
    pixels = b"".join(data[o:o + n] for o, n in zip(tags[273], tags[279]))
    kind = {(8, 1): "u1", (16, 1): "u2", (32, 3): "f4"}[bits, form]
    values = numpy.frombuffer(pixels, dtype=numpy.dtype(order + kind))
    return values.reshape(tags[257][0], tags[256][0], tags[277][0])


def read_exr(path):
    """List of (channel names, array [y, x, channel]), one a part, of an uncompressed OpenEXR file of floats."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01"
    many = bool(struct.unpack("<I", data[4:8])[0] & 0x1000)
    at, headers = 8, []
    while data[at] != 0:
        attributes = {}
        while data[at] != 0:
            name_end = data.index(0, at)
            type_end = data.index(0, name_end + 1)
            size = struct.unpack("<I", data[type_end + 1:type_end + 5])[0]
            attributes[data[at:name_end].decode()] = data[type_end + 5:type_end + 5 + size]
            at = type_end + 5 + size
        at += 1
        headers.append(attributes)
        if not many:
            break
    if many:
        at += 1
    parts = []
    for header in headers:
        assert header["compression"] == b"\0"
        x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
        width, height = x1 - x0 + 1, y1 - y0 + 1
        names = exr_channels(header["channels"])
        rows = numpy.zeros((height, len(names), width), dtype="<f4")
        for offset in struct.unpack(f"<{height}Q", data[at:at + 8 * height]):
            if many:
                assert struct.unpack("<i", data[offset:offset + 4])[0] == len(parts)
                offset += 4
            y, size = struct.unpack("<iI", data[offset:offset + 8])
            assert size == 4 * width * len(names)
            rows[y - y0] = numpy.frombuffer(data, "<f4", width * len(names), offset + 8).reshape(len(names), width)
        at += 8 * height
        parts.append((names, rows.transpose(0, 2, 1)))
    return parts


def exr_channels(data):
    names, at = [], 0
    while data[at] != 0:
        end = data.index(0, at)
        kind = struct.unpack("<i", data[end + 1:end + 5])[0]
        assert kind == 2, "not float"
        names.append(data[at:end].decode())
        at = end + 17
    return names


def read_hdr(path):
    """Array [y, x, 3] of a Radiance picture with run-length encoded or flat RGBE scanlines."""
    data = path.read_bytes()
    assert data.startswith(b"#?RADIANCE") or data.startswith(b"#?RGBE")
    at = data.index(b"\n\n") + 2
    end = data.index(b"\n", at)
    _, height, _, width = data[at:end].split()
    height, width, at = int(height), int(width), end + 1
    image = numpy.zeros((height, width, 4))
    for y in range(height):
        if data[at] == 2 and data[at + 1] == 2 and width >= 8 and data[at + 2] * 256 + data[at + 3] == width:
            at += 4
            for c in range(4):
                x = 0
                while x < width:
                    count = data[at]
                    if count > 128:
                        image[y, x:x + count - 128, c] = data[at + 1]
                        x, at = x + count - 128, at + 2
                    else:
                        image[y, x:x + count, c] = list(data[at + 1:at + 1 + count])
                        x, at = x + count, at + 1 + count
        else:
            image[y] = numpy.frombuffer(data, "u1", 4 * width, at).reshape(width, 4)
            at += 4 * width
    return (image[:, :, :3] + 0.5) * 2.0 ** (image[:, :, 3:] - 128 - 8) * (image[:, :, 3:] > 0)

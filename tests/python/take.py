"""Reads a take with independent libraries: `take.py FILE [EXPORT.npy]`.

Every frame is decoded by mcap-ros2-support and compared with NumPy on the bytes of its message. Every view is decoded
by mcap-protobuf-support. Attachments and metadata must be there. A truncated file is read up to its end. Prints the
number of messages of each topic as JSON.
"""

import collections
import json
import os
import struct
import sys

import numpy as np
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2

KINDS = {"uint8": "u1", "uint16": "<u2", "uint32": "<u4", "uint64": "<u8", "float32": "<f4", "float64": "<f8"}


def dtype(schema):
    """Returns the message definition as a NumPy row type, or None if messages vary in length."""
    fields = []
    for line in schema.data.decode().splitlines():
        kind, name = line.split()
        base, _, size = kind.partition("[")
        size = size.rstrip("]")
        if base == "string" or kind.endswith("[]"):
            return None
        fields.append((name, KINDS[base], (int(size),)) if size else (name, KINDS[base]))
    return np.dtype(fields)


def same(message, row):
    for name in row.dtype.names:
        value = getattr(message, name)
        value = list(value) if isinstance(value, bytes) else value
        mine = np.asarray(value, dtype=row.dtype[name].base)
        assert mine.tobytes() == np.asarray(row[name]).tobytes(), (name, mine, row[name])


def main(path, export):
    schemas, channels, decoders, rows = {}, {}, {}, {}
    counts = collections.Counter()
    attachments, metadata, frames = {}, {}, []
    ros2, protobuf = Ros2(), Protobuf()
    stream = iter(StreamReader(open(path, "rb")).records)
    while True:
        try:
            record = next(stream)
        except StopIteration:
            break
        except Exception as e:  # the libraries have several for a file that ends early
            print("cut off:", type(e).__name__)
            break
        if isinstance(record, Schema):
            schemas[record.id] = record
            if record.encoding == "ros2msg":
                rows[record.id] = dtype(record)
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Attachment):
            attachments[record.name] = record.data
        elif isinstance(record, Metadata):
            metadata[record.name] = record.metadata
        elif isinstance(record, Message):
            channel = channels[record.channel_id]
            schema = schemas[channel.schema_id]
            if channel.id not in decoders:
                factory = ros2 if channel.message_encoding == "cdr" else protobuf
                decoders[channel.id] = factory.decoder_for(channel.message_encoding, schema)
                assert decoders[channel.id], (channel.topic, channel.message_encoding, schema.encoding)
            message = decoders[channel.id](record.data)
            counts[channel.topic] += 1
            row = rows.get(schema.id)
            if row is not None:
                body = record.data[4:]
                assert record.data[:4] == b"\x00\x01\x00\x00" and len(body) == row.itemsize, channel.topic
                same(message, np.frombuffer(body, row)[0])
                if channel.topic == "/device/left/in":
                    frames.append(body)
            elif channel.topic == "/sound":
                n, = struct.unpack_from("<I", record.data, 20)
                exact = np.frombuffer(record.data, "<f8", n, 28)
                assert np.array_equal(np.asarray(message.samples), exact) and len(message.samples) == n
            elif channel.topic == "/change":
                assert sum(message.length) == len(message.place) == len(message.coef) and list(message.param)
            elif channel.topic == "/param":
                assert message.name == "stiff" and 100 <= message.value <= 2000
            elif channel.topic == "/audio":
                assert message.format == "pcm-s16" and message.number_of_channels == 2 and len(message.data) % 4 == 0
            elif channel.topic == "/masses":
                points = np.frombuffer(message.data, "<f4").reshape(-1, 3)
                assert message.point_stride == 12 and len(points) == 3 and np.isfinite(points).all()
            elif channel.topic == "/scene":
                assert len(message.entities[0].lines[0].points) == 4
            elif channel.topic == "/gesture/joints":
                assert [j.name for j in message.joints][:1] == ["key"] and len(message.joints) == 5
    take = metadata["ca.take"]
    assert take["format"] == "1" and json.loads(take["devices"]) == ["left", "right"], take
    assert b"[TGR]" in attachments["model/duo.ca.toml"] and b"231 Hz" in attachments["resolved.ca.toml"]
    assert json.loads(attachments["layout/ca-foxglove.json"])["configById"]
    assert {"profile/left.toml", "calibration/right.toml"} <= attachments.keys()
    if os.path.exists(export):
        array = np.load(export)
        assert array.tobytes() == b"".join(frames) and array["pos"].shape == (len(frames), 32)
    print(json.dumps(counts))


main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "")

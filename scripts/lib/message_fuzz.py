"""Messages with fields that no robot should send."""

import copy
import math

import genpy
import roslib.message

FLOATS = [math.nan, math.inf, -math.inf, 1e300, -1e300, -1.0, 0.0, 1e-320]
FLOAT32S = [math.nan, math.inf, -math.inf, 3e38, -3e38, -1.0, 0.0]
TEXTS = ["", "x" * 1000, "/", "no such frame", "map\n", "\u00fc"]
TIMES = [(0, 0), (0, 1), (2**32 - 1, 999999999), (1, 0)]
LENGTHS = [0, 1, 7, 1000]


def spoiled(message, draw, fields=1):
    """A copy with so many senseless fields, however deep they lie. `draw` is a random.Random. What is
    not spoiled is shared with `message`, so that large messages can be spoiled at a high rate."""
    for _ in range(fields):
        message = spoil(message, draw)
    return message


def spoil(message, draw):
    if not message.__slots__:
        return message
    copied = copy.copy(message)
    slot, kind = draw.choice(list(zip(message.__slots__, message._slot_types)))
    setattr(copied, slot, spoiled_field(getattr(message, slot), kind, draw))
    return copied


def spoiled_field(value, kind, draw):
    if isinstance(value, bytes):  # uint8[]
        return spoiled_bytes(value, draw) if kind.endswith("[]") else value
    if kind.endswith("]"):
        element, length = kind[:-1].split("[")
        return spoiled_list(list(value), element, bool(length), draw)
    if isinstance(value, genpy.Message):
        return spoil(value, draw)
    return bad_value(kind, draw)


def spoiled_bytes(value, draw):
    if value and draw.random() < 0.5:
        at = draw.randrange(len(value))
        return value[:at] + bytes([draw.randrange(256)]) + value[at + 1:]
    return (value + bytes(1000))[:draw.choice(LENGTHS + [max(0, len(value) - 1), len(value) + 1])]


def spoiled_list(values, kind, fixed, draw):
    if values and (fixed or draw.random() < 0.7):
        at = draw.randrange(len(values))
        values[at] = spoiled_field(values[at], kind, draw)
    elif not fixed:
        length = draw.choice(LENGTHS + [max(0, len(values) - 1), len(values) + 1])
        values = (values + [blank(kind) for _ in range(length - len(values))])[:length]
    return values


def blank(kind):
    if kind in ("time", "duration"):
        return genpy.Time() if kind == "time" else genpy.Duration()
    if "/" in kind:
        return roslib.message.get_message_class(kind)()
    return {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}.get(kind, 0)


def bad_value(kind, draw):
    """Of a basic type: allowed on the wire, and out of place."""
    if kind in ("float32", "float64"):
        return draw.choice((FLOATS if kind == "float64" else FLOAT32S) + [draw.uniform(-1e3, 1e3)])
    if kind == "bool":
        return draw.choice([True, False])
    if kind == "string":
        return draw.choice(TEXTS)
    if kind in ("time", "duration"):
        seconds, nanoseconds = draw.choice(TIMES)
        return genpy.Time(seconds, nanoseconds) if kind == "time" else genpy.Duration(min(seconds, 2**31 - 1))
    low, high = bounds({"byte": "int8", "char": "uint8"}.get(kind, kind))
    return draw.choice([low, high, 0, 1, max(low, -1)])


def bounds(kind):
    bits = int(kind.lstrip("uint"))
    return (0, 2**bits - 1) if kind.startswith("u") else (-2**(bits - 1), 2**(bits - 1) - 1)

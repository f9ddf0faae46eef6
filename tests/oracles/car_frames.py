"""Car frames from the table in docs/car-firmware.md, read the slow way: each substring is tried."""

from __future__ import annotations


def crc16(data):
    """CRC-16/CCITT-FALSE, bit by bit: polynomial 0x1021, begun with 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        for bit in range(7, -1, -1):
            top = (crc >> 15) ^ (byte >> bit & 1)
            crc = (crc << 1 & 0xFFFF) ^ (0x1021 if top else 0)
    return crc


def write_frame(seq, mode, cars):
    """A frame from whole numbers: cars are (address, steer, throttle), -127 to 127."""
    body = [3 + 3 * len(cars), seq % 256, seq // 256, mode]
    for address, steer, throttle in cars:
        body += [address, steer % 256, throttle % 256]
    crc = crc16(body)
    return bytes([0x80, 0x80, *body, crc // 256, crc % 256])


def read_frame(data):
    """(seq, mode, cars) if the bytes are one valid frame, else None."""
    if len(data) < 8 or data[0] != 0x80 or data[1] != 0x80 or len(data) != data[2] + 5:
        return None
    if data[2] % 3 or data[2] > 93 or crc16(data[2:-2]) != data[-2] * 256 + data[-1]:
        return None
    seq, mode, cars = data[3] + 256 * data[4], data[5], []
    for k in range(6, len(data) - 2, 3):
        steer, throttle = (v if v < 128 else v - 256 for v in data[k + 1 : k + 3])
        cars.append((data[k], steer, throttle))
    addresses = [car[0] for car in cars]
    if mode > 2 or 0 in addresses or 255 in addresses or len(set(addresses)) < len(addresses):
        return None
    if any(-128 in car[1:] or (mode != 1 and car[2]) for car in cars):
        return None
    return seq, mode, cars


def read_stream(data):
    """Every valid frame of a stream, in the order in which they end; none uses a byte twice."""
    found, used = [], 0
    for end in range(len(data) + 1):
        for start in range(max(used, end - 98), end):
            frame = read_frame(data[start:end])
            if frame is not None:
                found.append(frame)
                used = end
                break
    return found

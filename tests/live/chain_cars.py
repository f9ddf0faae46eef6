"""The cars of Jacobs et al., figure 6: byte 0 is the address; others' commands are passed on."""

from __future__ import annotations


class ChainCar:
    """One car of the chain: three bytes at a time, for itself or for the next."""

    def __init__(self, address, behind=None):
        self.address = address
        self.behind = behind
        self.waiting = b""
        self.taken = []

    def feed(self, data):
        self.waiting += data
        while len(self.waiting) >= 3:
            command, self.waiting = self.waiting[:3], self.waiting[3:]
            if command[0] == self.address:
                self.taken.append(tuple(v if v < 128 else v - 256 for v in command[1:]))
            elif self.behind is not None:
                self.behind.feed(command)


def chain_of(count):
    """Cars 1 to `count`, each with the next behind it."""
    behind, cars = None, []
    for address in range(count, 0, -1):
        behind = ChainCar(address, behind)
        cars.insert(0, behind)
    return cars

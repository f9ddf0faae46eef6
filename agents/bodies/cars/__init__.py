"""The parts of a car: command and radio, chassis, looking ahead, and what cars tell each other."""

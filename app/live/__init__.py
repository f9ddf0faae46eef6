"""Real cars: tracking, car links, the control loop and what keeps it safe."""

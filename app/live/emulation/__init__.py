"""Cars, firmware and tracking in software."""

"""What a model is: how rules, bodies and parameters are declared, called and cited."""

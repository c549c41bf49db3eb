"""The literal evaluator: plain Python that follows the definitions one by one, the oracle of the others."""

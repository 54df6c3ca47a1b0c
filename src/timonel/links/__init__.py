"""The wires of a vehicle, one transport a file: ports that carry lines and buses that carry frames."""

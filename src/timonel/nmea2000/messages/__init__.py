"""The declared PGNs, one file a topic. `nmea2000.registry` finds them by number."""

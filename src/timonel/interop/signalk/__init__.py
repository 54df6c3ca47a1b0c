"""Signal K: what is known about a boat in the names and units of its schema 1.7, and the deltas that tell it.

All of it is pure: `boat` says what is known, `model` what of that has changed, `deltas` puts it into words, and
`subscriptions` tells what a client wants and when. Source: signalk.org/specification 1.7.0 and its schemas.
"""

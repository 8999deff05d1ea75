from mpmkit.testing import conformance

test_everything_registered = conformance()

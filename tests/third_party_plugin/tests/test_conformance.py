from mpmkit.testing import conformance

test_mooney = conformance("mooney")

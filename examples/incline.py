"""A block on an incline with Coulomb friction: it slides with g (sin - mu cos), or sticks if tan(theta) <= mu."""

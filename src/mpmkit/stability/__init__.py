"""Hard cases for numerical stability: every component and composition is run through them."""

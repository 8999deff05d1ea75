"""Contact algorithms. Without one, all bodies share one velocity field and stick where they meet."""

import mpmkit as mpm
from mpmkit_contacts.frictional import FrictionalContact


@mpm.hookimpl
def mpmkit_components():
    """Return the contact algorithms of this plugin."""
    return [FrictionalContact]

"""Models beside the compiled core: contacts, targets, scenes, parameter paths, and what is drawn of them."""

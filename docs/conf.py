"""How Sphinx makes the site from this folder: `make docs`."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "lissom"
author = "the lissom developers"
version = release = version_of("lissom")
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "accessible",
    "benchmark_numbers",
    "mathml",
    "scene_reports",
]
exclude_patterns = ["pictures", "extensions", "**/.ipynb_checkpoints"]

myst_enable_extensions = ["amsmath", "attrs_block", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

# Notebooks have no outputs in the repository; they run here, and one that fails fails the site.
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 120

# Types in docstrings are words; a name in single backticks is looked up, and is code where nothing is found.
default_role = "py:obj"
autodoc_member_order = "bysource"
# Bridges are documented without what they lead to.
autodoc_mock_imports = ["jax", "torch", "stable_baselines3"]
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_validation_checks = set()

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

html_theme = "furo"
html_title = f"lissom {version}"
html_favicon = "static/favicon.svg"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = [("gallery.js", {"defer": "defer"})]
html_show_sphinx = False
html_show_copyright = False
html_math_renderer = "mathml"
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "native"

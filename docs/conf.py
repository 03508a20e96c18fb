"""The documents as a site: tools/docs builds it. Sphinx and MyST read the same Markdown that a code host shows."""

from pybtex.plugin import register_plugin
from pybtex.style.formatting.plain import Style as PlainStyle
from pybtex.style.labels import BaseLabelStyle

project = "Penumbra"
project_copyright = "the Penumbra authors"
extensions = ["myst_parser", "sphinxcontrib.bibtex"]
bibtex_bibfiles = ["references.bib"]
source_suffix = {".md": "markdown"}
root_doc = "index"
exclude_patterns = ["README.md"]

# Links to headings, as a code host makes them.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

html_theme = "furo"
html_title = "Penumbra"
html_static_path = ["site"]
html_css_files = ["wide-tables.css"]
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}


class _KeysAsLabels(BaseLabelStyle):
    """The pages write [Chan2004]; so does the list."""

    def format_labels(self, sorted_entries):  # type: ignore[no-untyped-def]
        return [entry.key for entry in sorted_entries]


class _Style(PlainStyle):
    default_label_style = _KeysAsLabels


register_plugin("pybtex.style.formatting", "penumbra", _Style)

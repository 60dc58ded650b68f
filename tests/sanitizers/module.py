"""A pytest plugin that loads the native module from $UWSIM_NATIVE_MODULE, compiled with a sanitizer."""

from __future__ import annotations

import os
import sys
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location


class _Finder:
    @staticmethod
    def find_spec(name: str, *_: object) -> ModuleSpec | None:
        return spec_from_file_location(name, os.environ["UWSIM_NATIVE_MODULE"]) if name == "uwsim._core" else None


sys.meta_path.insert(0, _Finder)

"""Compiles kernels with the steps that they need, and parts of kernels only as far as kernels need them.

Left to itself numba optimises each function and turns it into machine code, also one that only other compiled functions
call, which get its optimised text and do both again.  A part stays text, and what it calls is linked to it; a kernel is
optimised and compiled as a whole.  Below `solver` and `scenarios`, as `tumble.kernel_cache` is.
Source: numba 0.61 to 0.68, numba/core/codegen.py, and its documented `pipeline_class`.  A later numba compiles in its
own way, which takes longer and gives the same code.
"""

from inspect import signature
from types import SimpleNamespace
from typing import Any

import numba
from llvmlite.binding import parse_bitcode
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager

from tumble.garbage import without_garbage_collection

IS_KNOWN = (0, 61) <= tuple(map(int, numba.__version__.split(".")[:2])) <= (0, 68)
# Before numba 0.62 LLVM's passes belonged to one module.
PASSES_OF_A_MODULE = IS_KNOWN and "llvm_module" in signature(JITCPUCodegen._function_pass_manager).parameters


class KernelLibrary(JITCodeLibrary):
    """The code of a function, whose mere declarations of others are not optimised.

    One that was saved is loaded without its text, which only a function that is compiled with calls of it needs.
    """

    _saved_text = b""

    def serialize_using_object_code(self) -> Any:
        """Return its name, what kind of code this is, and its code, text and symbols."""
        name, kind, (code, text) = super().serialize_using_object_code()
        module = self._get_module_for_linking()
        symbols = (each for every in (module.functions, module.global_variables) for each in every)
        return name, kind, (code, text, {each.name for each in symbols if not each.is_declaration})

    @classmethod
    def _unserialize(cls, codegen: Any, state: tuple[str, str, tuple]) -> JITCodeLibrary:
        name, _, (code, text, *more) = state
        if not more:  # of a function that numba compiled in its own way
            return super()._unserialize(codegen, state)
        (symbols,) = more
        library = cls(codegen, name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._saved_text = text
        library._finalize_final_module()
        codegen._engine._defined_symbols |= symbols
        return library

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None and self._saved_text:
            self._shared_module = parse_bitcode(self._saved_text)
        return super()._get_module_for_linking()

    def _optimize_functions(self, ll_module: Any) -> None:
        if PASSES_OF_A_MODULE:
            super()._optimize_functions(ll_module)
            return
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class PartLibrary(KernelLibrary):
    """The text of a part, to be linked to kernels."""

    @property
    def codegen(self) -> Any:
        """What compiles, without the address of the part's constants, which has none."""
        return SimpleNamespace(set_env=lambda name, environment: None)

    def _optimize_final_module(self) -> None:
        """Leave this to the kernel."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return no address, as of a function that Python cannot call."""
        self._ensure_finalized()
        return 0


class _WithLibrary(Compiler):
    library_class: type[JITCodeLibrary]

    def define_pipelines(self) -> list[PassManager]:
        """Return numba's steps, without those for what no kernel has.

        That is `with`, closures, `literal_unroll`, an exception whose arguments are computed, and whole arrays in an
        expression; and without the notes for `inspect_types`.  Each step looks through the whole function, and several
        compute again where its variables live.  IRLegalization marks where that ends, which LLVM needs to know.
        """
        steps = PassManager("nopython")
        for step in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            untyped_passes.RewriteSemanticConstants,
            untyped_passes.DeadBranchPrune,
            untyped_passes.GenericRewrites,
            untyped_passes.InlineInlinables,
            untyped_passes.DeadBranchPrune,
            untyped_passes.ReconstructSSA,
            untyped_passes.DeadBranchPrune,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.InlineOverloads,
            typed_passes.IRLegalization,
            typed_passes.NativeLowering,
            typed_passes.NoPythonBackend,
        ):
            steps.add_pass(step, step.__name__)
        steps.finalize()
        return [steps]

    def compile_extra(self, func: Any) -> Any:
        """Compile a function into a library of the class."""
        self.state.library = self.library_class(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        with without_garbage_collection():
            return super().compile_extra(func)


class _Kernel(_WithLibrary):
    """Compiles what Python can call."""

    library_class = KernelLibrary


class _Part(_WithLibrary):
    """Compiles what only other compiled functions call."""

    library_class = PartLibrary


KernelCompiler: type[Compiler] = _Kernel if IS_KNOWN else Compiler
PartCompiler: type[Compiler] = _Part if IS_KNOWN else Compiler

"""Conan 2 recipe of softcd: shared libraries, built from the clone that this file is in. packaging/README.md has the commands."""

import os
import re
import shutil

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load

ROOT = os.path.join("..", "..")
FILES = ["CMakeLists.txt", "LICENSE"]
FOLDERS = ["cmake", "kernels", "plugin", "bullet_integration"]


class Softcd(ConanFile):
    name = "softcd"
    description = "Collision detection between deformable triangle meshes, on the CPU and on CUDA, for Bullet and without"
    license = "Zlib"
    topics = ("collision-detection", "soft-body", "cloth", "bullet", "cuda")
    package_type = "shared-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"bullet": [True, False], "cuda": [True, False]}
    default_options = {"bullet": True, "cuda": False}

    def set_version(self):
        header = load(self, os.path.join(self.recipe_folder, ROOT, "kernels", "include", "softcd", "version.hpp"))
        self.version = re.search(r'SOFTCD_VERSION_STRING "([^"]+)"', header).group(1)

    def export_sources(self):
        root = os.path.join(self.recipe_folder, ROOT)
        for name in FILES:
            shutil.copy2(os.path.join(root, name), self.export_sources_folder)
        for name in FOLDERS:
            copy(self, "*", os.path.join(root, name), os.path.join(self.export_sources_folder, name))

    def requirements(self):
        self.requires("onetbb/[>=2021.8 <2023]")
        self.requires("fmt/[>=9 <12]")
        self.requires("highway/[>=1.0.3 <2]")
        if self.options.bullet:
            self.requires("bullet3/[>=3.24 <4]", transitive_headers=True, transitive_libs=True)

    def layout(self):
        cmake_layout(self)

    def _bullet_folder(self):
        """Where Conan's Bullet is; none where the system's is used instead."""
        bullet = [d for r, d in self.dependencies.host.items() if r.ref.name == "bullet3"]
        return bullet[0].package_folder if bullet else None

    def generate(self):
        dependencies = CMakeDeps(self)
        dependencies.set_property("highway", "cmake_file_name", "hwy")
        dependencies.set_property("highway::hwy", "cmake_target_name", "hwy::hwy")
        dependencies.generate()
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["SOFTCD_BULLET"] = bool(self.options.bullet)
        toolchain.cache_variables["SOFTCD_CUDA"] = "ON" if self.options.cuda else "OFF"
        for unused in ("SOFTCD_DEMOS", "SOFTCD_TESTS", "SOFTCD_BENCHMARKS"):
            toolchain.cache_variables[unused] = False
        if self._bullet_folder():
            toolchain.cache_variables["BULLET_ROOT"] = self._bullet_folder()
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        # The installed CMake files describe the package. Shared libraries need none of the libraries that they were
        # built with.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "softcd")]
        self.cpp_info.libs = ["softcd_bullet", "softcd"] if self.options.bullet else ["softcd"]
        if self.options.bullet and self._bullet_folder():
            self.buildenv_info.define_path("BULLET_ROOT", self._bullet_folder())

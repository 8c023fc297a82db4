#pragma once

namespace softcd::demo {

/// Runs softcd-detect with main's arguments and returns main's result. Throws nothing.
int detect_program(int argc, char** argv);

}  // namespace softcd::demo

#pragma once

namespace softcd::demo {

/// Runs softcd-certify with main's arguments and returns main's result. Throws nothing.
int certify_program(int argc, char** argv);

}  // namespace softcd::demo

#pragma once

namespace softcd::demo {

/// softcd-detect: what main is given and returns. Throws nothing.
int detect_program(int argc, char** argv);

}  // namespace softcd::demo

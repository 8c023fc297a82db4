#pragma once

#include "command_line.hpp"
#include "measurement.hpp"

namespace softcd::demo {

/// Writes one row for each contact; --help describes the columns. Throws std::runtime_error when writing fails.
void write_contacts(const std::string& file, Span<const Contact> contacts);

/// Writes every figure of the detection. Throws std::runtime_error when writing fails.
void write_json(const DetectCommand& command, const Statistics& statistics);

/// Prints a summary on standard output.
void print_summary(const DetectCommand& command, const Statistics& statistics);

}  // namespace softcd::demo

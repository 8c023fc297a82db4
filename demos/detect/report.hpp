#pragma once

#include "command_line.hpp"
#include "measurement.hpp"

namespace softcd::demo {

/// One row per contact; the columns are described in --help. Throws std::runtime_error when writing fails.
void write_contacts(const std::string& file, Span<const Contact> contacts);

/// Every figure of the detection. Throws std::runtime_error when writing fails.
void write_json(const DetectCommand& command, const Statistics& statistics);

/// A summary for people, on standard output.
void print_summary(const DetectCommand& command, const Statistics& statistics);

}  // namespace softcd::demo

#pragma once

#include "command_line.hpp"
#include "measurement.hpp"
#include "mesh_tools/mesh_io.hpp"

namespace softcd::demo {

/// Writes one row for each contact; --help describes the columns. Throws std::runtime_error when writing fails.
void write_contacts(const std::string& file, Span<const Contact> contacts);

/// Writes every figure of the detection. Throws std::runtime_error when writing fails.
void write_json(const DetectCommand& command, const Statistics& statistics);

/// Writes the regions' figures. Throws std::runtime_error when writing fails.
void write_regions_json(const DetectCommand& command, const IntersectionRegions& found);

/// Returns a colour for each triangle: that of its region's kind, or grey.
std::vector<mesh_tools::Rgb> colours_of(std::size_t triangle_count, const IntersectionRegions& found);

/// Prints the regions on standard output.
void print_regions(const IntersectionRegions& found);

/// Prints a summary on standard output.
void print_summary(const DetectCommand& command, const Statistics& statistics);

}  // namespace softcd::demo

#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <tuple>
#include <vector>

#include "softcd/core/types.hpp"

namespace softcd::demo {

/// The options that decide a certificate, apart from the meshes.
struct CertifyOptions {
  double margin = 0;         ///< each surface's; features must stay more than twice this apart
  std::uint32_t every = 1;   ///< 1: every frame; n: the first of every n frames
  std::uint32_t list = 100;  ///< the most pairs that are listed for a step or a frame
};

/// Two features that a detection reports. Meshes are numbered: 0 is that of the frames, then come those of --against.
struct ReportedPair {
  ContactKind kind;
  std::uint32_t mesh_a, mesh_b;
  std::array<std::uint32_t, 4> vertices;  ///< as in Contact
  float time;                             ///< of the step; never late
  bool passes_through;                    ///< exact arithmetic shows that the features pass through each other
};

/// Two triangles, in order: the first one is of mesh 0, and comes before the second one if both are.
struct TrianglePair {
  std::uint32_t triangle_a;  ///< index in mesh 0
  std::uint32_t mesh_b, triangle_b;
  bool is_through;  ///< a side passes through the other triangle's inside; else they touch

  friend bool operator<(const TrianglePair& a, const TrianglePair& b) {
    return std::tie(a.triangle_a, a.mesh_b, a.triangle_b) < std::tie(b.triangle_a, b.mesh_b, b.triangle_b);
  }
};

/// The number of pairs, and those of them that are listed.
template <class Pair>
struct PairList {
  std::size_t count = 0;
  std::vector<Pair> listed;
};

enum class Verdict {
  proved,
  crossed,     ///< exact arithmetic shows that features passed through each other
  not_proved,  ///< features touched, or came within rounding of it
};

struct StepResult {
  Verdict verdict = Verdict::proved;
  PairList<ReportedPair> pairs;    ///< those that pass through each other first, then the earliest
  PairList<TrianglePair> changed;  ///< pass through each other at one end of the step, apart at the other
};

/// The files of one mesh that were read.
struct CertifiedMesh {
  std::size_t vertices = 0, triangles = 0;
  std::vector<std::string> names;   ///< of the files, without folders
  std::vector<std::string> hashes;  ///< of their content
};

struct Certificate {
  CertifyOptions options;
  std::vector<CertifiedMesh> meshes;
  std::vector<PairList<TrianglePair>> frames;  ///< the triangles that intersect in each frame
  std::vector<StepResult> steps;               ///< from each frame to the next

  bool is_proved() const;
};

/// Returns the sentence that a certificate proves.
std::string claim_of(const CertifyOptions& options);

/// Returns the certificate as JSON: the same bytes on every machine.
std::string text_of(const Certificate& certificate);

/// Prints what is not proved, and the verdict, on standard output.
void print_summary(const Certificate& certificate);

/// A certificate that was read from a file.
struct WrittenCertificate {
  std::string file;
  std::string text;
  CertifyOptions options;
  std::vector<std::size_t> frame_counts;  ///< of each mesh
};

/// Throws MeshError, naming the file, when it cannot be read as a certificate.
WrittenCertificate read_certificate(const std::string& file);

/// Returns what is different in a certificate that was made again, as a sentence; empty if the bytes are the same.
std::string difference(const WrittenCertificate& written, const std::string& text);

}  // namespace softcd::demo

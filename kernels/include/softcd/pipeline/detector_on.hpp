#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "softcd/pipeline/backend.hpp"
#include "softcd/pipeline/detection_run.hpp"

namespace softcd {

/// The detector on one backend. Another `Scheme` is in benchmarks/paper.
template <DetectionBackend Backend, class Scheme = ExactScheme>
class DetectorOn final : public Detector {
 public:
  template <class... Arguments>
  explicit DetectorOn(Arguments... arguments) : memory_(arguments...) {}

  bool set_memory_limit(std::uint64_t bytes, QueryMemory& query) override {
    MemoryAccount& account = *memory_.account;
    if (bytes == account.limit()) return true;
    const auto is_exceeded = [&] { return bytes > 0 && account.bytes() > bytes; };
    if (is_exceeded()) memory_.release_lists();
    if (is_exceeded()) query.release();
    const bool keeps_scene = !is_exceeded();
    if (!keeps_scene) memory_.scene.release();
    account.set_limit(bytes);
    ++revision_;
    return keeps_scene;
  }

  void set_scene(const SceneArrays& scene, const SceneChanges& changes) override {
    needs_ = MemoryNeed::For::scene;
    memory_.with_lists_or_without([&] { memory_.scene.follow(memory_.backend, scene, changes); });
    if (std::exchange(scene_revision_, scene.revision) != scene.revision) ++revision_;
  }

  std::unique_ptr<QueryMemory> make_query() override { return std::make_unique<QueryOn<Backend>>(memory_.account); }

  void start(QueryMemory& query, const SceneBodies& bodies, const DetectionSettings& settings) override {
    auto& its_memory = static_cast<QueryOn<Backend>&>(query);
    run_.reset();
    memory_.backend.begin_detection(its_memory.session);
    memory_.account->forget_refusals();
    upload(its_memory, bodies);
    needs_ = MemoryNeed::For::lists;
    memory_.scene.begin_detection(settings, its_memory, bodies, puts_patches_into_cells<Backend, Scheme>(settings));
    run_.emplace(memory_, its_memory, bodies, settings, revision_);
    run_->start();
  }

  StayingContacts staying() const override { return run_ ? run_->staying() : StayingContacts(); }

  Span<const Contact> finish(Statistics& statistics) override {
    const Span<const Contact> contacts = run_->finish(statistics);
    report_memory(statistics);
    return contacts;
  }

  std::unique_ptr<QueryMemory> make_probe() override { return std::make_unique<ProbeOn<Backend>>(memory_.account); }

  void answer(QueryMemory& memory, const ProbedScene& scene, const Questions& ask) override {
    auto& probe = static_cast<ProbeOn<Backend>&>(memory);
    memory_.account->forget_refusals();
    memory_.with_lists_or_without([&] {
      upload_values(memory_.backend, probe.bodies, scene.bodies);
      SpatialQueriesOn<Backend> queries(memory_.backend, probe, memory_.scene.probed(memory_.backend, scene, probe));
      ask(queries);
    });
  }

  void report_memory(Statistics& statistics) const override {
    statistics.peak_bytes = memory_.account->peak_bytes();
    statistics.reruns = memory_.backend.reruns();
    statistics.chunks = run_ ? run_->chunks() : 1;
  }

  MemoryNeed memory_need() const override {
    const std::uint64_t bytes = memory_.account->refused_total();
    if (!run_) return {needs_, bytes, 0};
    const bool are_contacts = needs_ == MemoryNeed::For::lists && run_->is_full_of_contacts(bytes);
    return {are_contacts ? MemoryNeed::For::contacts : needs_, bytes, run_->found()};
  }

  TestSamples test_samples() const override { return run_ ? run_->test_samples() : TestSamples(); }

 private:
  void upload(QueryOn<Backend>& query, const SceneBodies& bodies) {
    if (query.has(bodies)) return;
    query.bodies_number = 0;
    memory_.with_lists_or_without([&] { query.upload(memory_.backend, bodies); });
    query.bodies_number = bodies.number;
  }

  DetectorMemory<Backend, Scheme> memory_;
  std::uint64_t scene_revision_ = 0;  ///< see SceneArrays
  std::uint64_t revision_ = 1;        ///< changes with the triangles and the memory that there is for them
  MemoryNeed::For needs_ = MemoryNeed::For::scene;    ///< what is being done
  std::optional<DetectionRun<Backend, Scheme>> run_;  ///< the detection that was started last
};

}  // namespace softcd

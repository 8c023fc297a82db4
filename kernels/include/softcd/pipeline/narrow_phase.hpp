#pragma once

#include "softcd/pipeline/broad_phase.hpp"
#include "softcd/pipeline/scene_mirror.hpp"
#include "softcd/stages/clear_word.hpp"
#include "softcd/stages/contact_order.hpp"
#include "softcd/stages/contact_output.hpp"
#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/feature_filters.hpp"
#include "softcd/stages/feature_pairs.hpp"

/// The narrow phase's stage order, once for all backends: triangle pairs in, sorted contacts out.
namespace softcd {

template <class Backend, class Scheme>
class NarrowPhaseStages {
 public:
  NarrowPhaseStages(Backend& backend, const SceneMirror<Backend>& mirror, Workspace<Backend, Scheme>& workspace,
                    const SceneView& scene, const DetectionSettings& settings, const SceneCounts& counts)
      : backend_(backend),
        mirror_(mirror),
        w_(workspace),
        lists_(workspace.lists),
        counters_(workspace.counters.data()),
        scene_(scene),
        settings_(settings),
        counts_(counts) {}

  /// Reserves the memory that test_neighbours() needs.
  void reserve_neighbours() {
    if (!scene_.self_collision) return;
    w_.spread_vertices.reserve(backend_, scene_.vertex_count, 0);
    w_.spread_triangles.reserve(backend_, scene_.triangle_count, 0);
    w_.spread_edges.reserve(backend_, scene_.edge_count, 0);
  }

  /// Adds candidates of triangles that share a vertex to this chunk's. Needs nothing that the broad phase finds.
  void test_neighbours() {
    if (!scene_.self_collision) return;
    find_spread_parts();
    if (scene_.is_swept) {
      test_all_neighbours<true>();
    } else {
      test_all_neighbours<false>();
    }
  }

  /// Finds the contacts of the pairs found so far in this chunk.
  void find_contacts() {
    if (scene_.is_swept) {
      find_candidates<true>();
    } else {
      find_candidates<false>();
    }
    backend_.begin(Stage::narrow);
    if (settings_.accuracy == Accuracy::fast) {
      find_contacts<float>();
    } else {
      find_contacts<double>();
    }
  }

  /// Writes the contacts of all chunks to `contacts`, whose capacity suffices, in order. If `in_runs`, orders them in
  /// runs, unless some runs are too long.
  void order_contacts(Contact* contacts, bool in_runs) {
    backend_.begin(Stage::sort);
    const Count count = lists_.found.count(counters_);
    const FeatureContact* found = lists_.found.template column<0>().data();
    const auto write = [&] { write_in_order(count, found, {scene_, contacts}, in_runs); };
    const auto summarize = [&] {
      backend_.minimum("earliest_contact", count, TimeOfContact{found}, &counters_->earliest_toi);
      if (is_continuous() && scene_.is_conservative) {
        backend_.for_each_append("count_unsettled", count, CountUnsettled{found},
                                 Appender<CountTarget>{{}, &counters_->unsettled, 0});
      }
    };
    backend_.concurrently(write, summarize);
  }

  /// Lets contacts be counted in their runs as they are found. For backends that do not know counts; reserve_runs() has
  /// succeeded, and there is memory to order all contacts.
  void count_in_runs() {
    counts_in_runs_ = true;
    clear_runs();
  }

  /// Reserves the memory to order contacts in runs.
  void reserve_runs() {
    // A quarter more than there are, so that slowly growing numbers of contacts seldom grow them.
    const std::uint64_t runs = planned_runs().run_count;
    if (runs <= w_.run_begins.capacity()) return;
    w_.run_counts.reserve(backend_, runs + runs / 4, 0);
    w_.run_begins.reserve(backend_, runs + runs / 4, 0);
  }

 private:
  SpreadParts spread_parts() { return {w_.spread_vertices.data(), w_.spread_triangles.data(), w_.spread_edges.data()}; }

  /// Finds the neighbours that need no test.
  void find_spread_parts() {
    backend_.for_each("test_stars", Count{&counters_->all, counts_.stars},
                      TestStar{scene_, mirror_.stars.data(), spread_parts()});
    backend_.for_each("find_spread_parts", Count{&counters_->all, scene_.triangle_count},
                      FindSpreadParts{scene_, spread_parts()});
  }

  RunPlan planned_runs() const {
    const Count contacts = lists_.found.count(counters_);
    return plan_runs(std::uint64_t{scene_.vertex_count} + scene_.edge_count,
                     Backend::kKnowsCounts ? contacts.get() : contacts.capacity);
  }

  ContactRuns runs() const { return {scene_.vertex_count, planned_runs().shift}; }
  Count run_count() const { return {&counters_->all, planned_runs().run_count}; }
  CountInRun run_counter() {
    return {runs(), lists_.found.template column<0>().data(), w_.run_counts.data(), w_.contact_order.data()};
  }

  void clear_runs() { backend_.for_each("clear_runs", run_count(), ClearWord{w_.run_counts.data()}); }

  void write_in_order(Count count, const FeatureContact* found, const WriteContact& write, bool in_runs) {
    if (in_runs && !counts_in_runs_) {
      clear_runs();
      backend_.for_each_append("count_in_runs", count, run_counter(),
                               Appender<CountTarget>{{}, &counters_->long_runs, 0});
    }
    if (!in_runs || (Backend::kKnowsCounts && counters_->long_runs > 0)) {
      sort_by_keys(count, found);
      backend_.for_each("write_contacts", count, WriteInOrder{write, found, w_.contact_order.data()});
      return;
    }
    const ContactRuns runs = this->runs();
    backend_.exclusive_scan("scan_runs", run_count(), w_.run_counts.data(), w_.run_begins.data(),
                            &counters_->contacts_in_runs);
    backend_.for_each("lay_into_runs", count,
                      LayIntoRun{runs, found, w_.run_begins.data(), w_.contact_order.data(), w_.contact_keys.data()});
    backend_.for_each(
        "write_in_runs", count,
        WriteInRun{write, {runs, found, w_.run_begins.data(), w_.run_counts.data(), w_.contact_keys.data()}});
  }

  /// Returns the list of contacts for stages that append to it.
  auto found_appender() {
    if constexpr (Backend::kKnowsCounts) {
      return lists_.found.appender(counters_);
    } else {
      const Count count = lists_.found.count(counters_);
      const RunTarget target = {lists_.found.template column<0>().data(),
                                counts_in_runs_ ? run_counter() : CountInRun{}, &counters_->long_runs};
      return Appender<RunTarget>{target, &counters_->contacts, count.capacity};
    }
  }

  void sort_by_keys(Count count, const FeatureContact* found) {
    const int first_bits = bits_for(std::max(scene_.vertex_count, scene_.edge_count));
    const int second_bits = bits_for(std::max(scene_.triangle_count, scene_.edge_count));
    backend_.for_each(
        "make_contact_keys", count,
        MakeContactKey{found, static_cast<std::uint32_t>(first_bits), static_cast<std::uint32_t>(second_bits),
                       w_.contact_keys.data(), w_.contact_order.data()});
    backend_.sort_pairs("sort_contacts", count, w_.contact_keys, w_.contact_order, 1 + first_bits + second_bits);
  }

  bool is_continuous() const { return settings_.detection == Detection::ccd; }

  template <class VertexTriangle, class EdgeEdge>
  void for_wanted_kinds(const VertexTriangle& vertex_triangle, const EdgeEdge& edge_edge) {
    if (settings_.vertex_triangle && settings_.edge_edge) {
      backend_.concurrently(vertex_triangle, edge_edge);
    } else if (settings_.vertex_triangle) {
      vertex_triangle();
    } else if (settings_.edge_edge) {
      edge_edge();
    }
  }

  template <bool kSwept>
  void test_all_neighbours() {
    for_wanted_kinds(
        [&] {
          test_neighbours<ContactKind::vertex_triangle, kSwept>(
              "test_vertex_triangle_neighbours", mirror_.vertex_triangle_neighbours.data(),
              counts_.vertex_triangle_neighbours, lists_.vt_candidates);
        },
        [&] {
          test_neighbours<ContactKind::edge_edge, kSwept>("test_edge_edge_neighbours",
                                                          mirror_.edge_edge_neighbours.data(),
                                                          counts_.edge_edge_neighbours, lists_.ee_candidates);
        });
  }

  template <ContactKind kKind, bool kSwept, class Candidates>
  void test_neighbours(const char* label, const std::uint64_t* neighbours, std::uint64_t all, Candidates& candidates) {
    const std::uint64_t first = settings_.partition.rank.begin(all);
    const Count count = {&counters_->all, settings_.partition.rank.end(all) - first};
    const TestNeighbours<kKind, kSwept> test{{scene_}, neighbours + first, spread_parts()};
    find_candidates_of(label, count, test, candidates);
  }

  /// Finds candidates that pass the bodies' filters, if there are some.
  template <class Find, class Candidates>
  void find_candidates_of(const char* label, Count items, const Find& find, Candidates& candidates) {
    const auto find_all = [&] {
      if (scene_.filters.are_set || scene_.looks_ahead()) {
        backend_.for_each_part_filtered(label, items, WithFilters<Find>{find}, candidates.appender(counters_));
      } else {
        backend_.for_each_part_filtered(label, items, find, candidates.appender(counters_));
      }
    };
    produce(backend_, counters_, find_all, candidates);
  }

  template <bool kSwept>
  void find_candidates() {
    backend_.begin(Stage::features);
    for_wanted_kinds(
        [&] { expand_pairs<ContactKind::vertex_triangle, kSwept>("expand_to_vertex_triangle", lists_.vt_candidates); },
        [&] { expand_pairs<ContactKind::edge_edge, kSwept>("expand_to_edge_edge", lists_.ee_candidates); });
  }

  template <ContactKind kKind, bool kSwept, class Candidates>
  void expand_pairs(const char* label, Candidates& candidates) {
    const ExpandPair<kKind, kSwept> expand_pair{
        {scene_}, w_.shapes.data(), w_.volumes.data(), lists_.pairs.template column<0>().data()};
    find_candidates_of(label, lists_.pairs.count(counters_), expand_pair, candidates);
  }

  template <class T>
  void find_contacts() {
    for_wanted_kinds(
        [&] { test_candidates<ContactKind::vertex_triangle, T>("test_vertex_triangle", lists_.vt_candidates); },
        [&] { test_candidates<ContactKind::edge_edge, T>("test_edge_edge", lists_.ee_candidates); });
  }

  template <ContactKind kKind, class T, class Candidates>
  void test_candidates(const char* label, Candidates& candidates) {
    const std::uint64_t* features = candidates.template column<0>().data();
    produce(
        backend_, counters_,
        [&] {
          const Count count = candidates.count(counters_);
          if (is_continuous() && scene_.is_conservative) {
            backend_.for_each_search(label, count, TestApproach<kKind>{scene_, features}, found_appender());
          } else if (is_continuous()) {
            backend_.for_each_append(label, count, TestMotion<kKind, T>{scene_, features}, found_appender());
          } else if (kKind == ContactKind::vertex_triangle && scene_.contact_rule == ContactRule::slab) {
            backend_.for_each_append(label, count, TestSlab<T>{scene_, features}, found_appender());
          } else {
            backend_.for_each_append(label, count, TestProximity<kKind, T>{scene_, features}, found_appender());
          }
        },
        lists_.found);
  }

  Backend& backend_;
  const SceneMirror<Backend>& mirror_;
  Workspace<Backend, Scheme>& w_;
  Lists<Backend, Scheme>& lists_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
  const SceneCounts& counts_;
  bool counts_in_runs_ = false;
};

}  // namespace softcd

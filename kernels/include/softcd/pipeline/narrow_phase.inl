#pragma once

#include "softcd/pipeline/broad_phase.inl"
#include "softcd/stages/contact_output.hpp"
#include "softcd/stages/contact_tests.hpp"
#include "softcd/stages/feature_pairs.hpp"

/// The narrow phase's stage order, once for all backends: triangle pairs in, sorted contacts out.
namespace softcd {

template <class Backend>
class NarrowPhaseStages {
 public:
  NarrowPhaseStages(Backend& backend, Workspace<Backend>& workspace, const SceneView& scene,
                    const DetectionSettings& settings)
      : backend_(backend), w_(workspace), counters_(workspace.counters.data()), scene_(scene), settings_(settings) {}

  void run() {
    backend_.begin(Stage::features);
    produce(
        backend_, counters_,
        [&] {
          backend_.for_each_append("expand_pairs", w_.pairs.count(counters_),
                                   ExpandPair{scene_, w_.volumes.data(), w_.pairs.template column<0>().data()},
                                   w_.vt_candidates.appender(counters_), w_.ee_candidates.appender(counters_));
        },
        w_.vt_candidates, w_.ee_candidates);

    backend_.begin(Stage::narrow);
    if (settings_.accuracy == Accuracy::fast) {
      test_candidates<float>();
    } else {
      test_candidates<double>();
    }

    backend_.begin(Stage::sort);
    sort_contacts();
  }

 private:
  template <class T>
  void test_candidates() {
    if (settings_.vertex_triangle) {
      test_kind<ContactKind::vertex_triangle, T>("test_vertex_triangle", w_.vt_candidates, w_.vt_contacts);
    }
    if (settings_.edge_edge) test_kind<ContactKind::edge_edge, T>("test_edge_edge", w_.ee_candidates, w_.ee_contacts);
  }

  template <ContactKind kKind, class T, class Candidates, class Contacts>
  void test_kind(const char* label, Candidates& candidates, Contacts& contacts) {
    const std::uint64_t* features = candidates.template column<0>().data();
    produce(
        backend_, counters_,
        [&] {
          const Count count = candidates.count(counters_);
          if (scene_.continuous) {
            backend_.for_each_append(label, count, TestMotion<kKind, T>{scene_, features},
                                     contacts.appender(counters_));
          } else {
            backend_.for_each_append(label, count, TestProximity<kKind, T>{scene_, features},
                                     contacts.appender(counters_));
          }
        },
        contacts);
  }

  void sort_contacts() {
    w_.contacts.reserve(backend_, w_.vt_contacts.capacity() + w_.ee_contacts.capacity(), 0);
    const Count none = {&counters_->vt_contacts, 0};
    sort_kind<ContactKind::vertex_triangle>(w_.vt_contacts, none, bits_for(scene_.vertex_count),
                                            bits_for(scene_.triangle_count));
    sort_kind<ContactKind::edge_edge>(w_.ee_contacts, w_.vt_contacts.count(counters_), bits_for(scene_.edge_count),
                                      bits_for(scene_.edge_count));
  }

  /// Writes behind the contacts of the kind `before`.
  template <ContactKind kKind, class Contacts>
  void sort_kind(Contacts& found, Count before, int high_bits, int low_bits) {
    if (found.capacity() == 0) return;
    const Count count = found.count(counters_);
    w_.contact_keys.reserve(backend_, found.capacity(), 0);
    w_.contact_order.reserve(backend_, found.capacity(), 0);
    const FeatureContact* contacts = found.template column<0>().data();
    backend_.for_each("make_contact_keys", count,
                      MakeContactKey{contacts, static_cast<std::uint32_t>(low_bits), w_.contact_keys.data(),
                                     w_.contact_order.data()});
    backend_.sort_pairs("sort_contacts", count, w_.contact_keys, w_.contact_order, high_bits + low_bits);
    backend_.for_each("write_contacts", count,
                      WriteContact<kKind>{scene_, contacts, w_.contact_order.data(), before, w_.contacts.data()});
    backend_.minimum("earliest_contact", count, TimeOfContact{contacts}, &counters_->earliest_toi);
  }

  Backend& backend_;
  Workspace<Backend>& w_;
  Counters* counters_;
  const SceneView& scene_;
  const DetectionSettings& settings_;
};

}  // namespace softcd

#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "interruptible_work.hpp"
#include "softcd/softcd.hpp"

namespace softcd::python {

/// One value for each vertex.
using VertexBits = nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

/// Pairs of bodies' numbers, in Python's form.
using NumberPairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A body in Python's form.
struct Mesh {
  std::vector<Triangle> triangles;
  std::vector<Segment> segments;
  std::uint32_t vertex_count;

  BodyDesc desc(const BodySettings& settings) const {
    BodyDesc desc{triangles, vertex_count, settings};
    desc.segments = segments;
    return desc;
  }
};

/// Reads a mesh. `segments` may be None.
Mesh read_mesh(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments);

/// Reads filters, one for each vertex. Missing groups are 1, missing masks all bits.
std::vector<VertexFilter> vertex_filters(const std::optional<VertexBits>& groups,
                                         const std::optional<VertexBits>& masks);

inline std::vector<BodyPair> body_pairs(const NumberPairs& numbers) {
  std::vector<BodyPair> pairs;
  pairs.reserve(numbers.size());
  for (const auto& [a, b] : numbers) pairs.push_back({{a}, {b}});
  return pairs;
}

/// An empty list, or one object, with the memory needed to discard it: releasing it allocates nothing.
using Discardable = std::list<std::shared_ptr<const void>>;

/// Objects that Python has released, on any thread. Only one thread at a time may use a scene, so the scene's next call
/// destroys them. The last owner destroys the remaining ones.
class Discarded {
 public:
  void add(Discardable& object) noexcept {
    const std::lock_guard lock(mutex_);
    objects_.splice(objects_.end(), object);
  }
  void give_back() {
    Discardable objects;
    const std::lock_guard lock(mutex_);
    objects.swap(objects_);
  }

 private:
  std::mutex mutex_;
  Discardable objects_;
};

/// Keeps contacts for as long as an array shows them.
class HeldContacts {
 public:
  HeldContacts(std::shared_ptr<const void> contacts, std::shared_ptr<Discarded> discarded)
      : contacts_(1), discarded_(std::move(discarded)) {
    contacts_.front() = std::move(contacts);
  }
  HeldContacts(HeldContacts&&) noexcept = default;
  HeldContacts& operator=(HeldContacts&&) = delete;
  ~HeldContacts() {
    if (discarded_ != nullptr) discarded_->add(contacts_);
  }

 private:
  Discardable contacts_;
  std::shared_ptr<Discarded> discarded_;
};

/// softcd::Scene for Python. Calls from several threads wait for each other, without the interpreter's lock. Arrays
/// that were set stay alive until they have been read. Arrays on a GPU stay alive until a detection has read others in
/// their place.
class BoundScene {
 public:
  BoundScene(const SceneOptions& options, nb::object log);
  BoundScene(const BoundScene&) = delete;
  BoundScene& operator=(const BoundScene&) = delete;

  std::uint32_t add_body(nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                         const BodySettings& settings);
  void update_body(std::uint32_t body, nb::handle triangles, std::uint32_t vertex_count, nb::handle segments,
                   nb::handle changed, const BodySettings& settings);
  void set_settings(std::uint32_t body, const BodySettings& settings);
  void remove_body(std::uint32_t body);
  bool has_body(std::uint32_t body);
  void set_positions(std::uint32_t body, nb::handle vertices_t0, nb::handle vertices_t1, bool check_finite);
  void set_ignored_pairs(const NumberPairs& pairs);
  void set_vertex_filters(std::uint32_t body, const std::optional<VertexBits>& groups,
                          const std::optional<VertexBits>& masks);
  void set_rest_positions(std::uint32_t body, nb::handle vertices);

  SceneOptions options();
  Backend backend();
  std::uint32_t body_count() const { return body_count_; }
  /// Returns an upper bound of the number of triangles.
  std::uint64_t triangles_given() const { return triangles_given_; }

  /// Calls f(scene) alone, without the interpreter's lock. Throws Error inside a callback of a call of this scene.
  /// Throws the exception of a signal's handler that raises while the call waits for another.
  template <class F>
  auto call(F f) {
    refuse_callbacks();
    release_spent();
    const nb::gil_scoped_release no_interpreter;
    const std::unique_lock alone = lock_between_signals();
    return use(f);
  }
  /// Makes a call that may take long: a signal's handler may raise during it. The work then continues by itself, and
  /// the next call waits for it. `owner` is a Python object that keeps the scene; f, or `owner`, keeps everything else.
  /// Each triangle may have to be compared with `others`; a detection's with all.
  template <class F>
  auto call_at_length(nb::handle owner, F f, std::optional<std::size_t> others = {}) {
    const std::uint64_t triangles = triangles_given_;
    if (!handles_signals() || others.value_or(triangles) * triangles <= kQuickWork) return call(std::move(f));
    refuse_callbacks();
    release_spent();
    auto alone = [this, f = std::move(f)]() mutable { return use(f); };
    using Work = InterruptibleWork<decltype(alone)>;
    return Work::run(std::make_shared<Work>(nb::borrow(owner), mutex_, std::move(alone)));
  }
  /// Makes a long call in which f reads the arrays that were set. When it throws, it may not have read them.
  template <class F>
  auto call_and_read(nb::handle owner, F f, std::optional<std::size_t> others = {}) {
    auto result = call_at_length(
        owner,
        [this, f = std::move(f)](Scene& scene) mutable {
          auto found = f(scene);
          spent_.merge(kept_);
          if (spent_on_device_.empty()) spent_on_device_.swap(replaced_);
          return found;
        },
        others);
    release_spent();
    return result;
  }

  const std::shared_ptr<Discarded>& discarded() const { return discarded_; }

  int traverse(visitproc visit, void* arg);
  void clear();

 protected:
  /// Calls set(scene), which passes on these arrays, and keeps them until they have been read. `body` is theirs, or
  /// the first of theirs. Called within call().
  template <class Set>
  void set_and_keep(Scene& scene, std::uint32_t body, bool is_on_device, std::array<Array, 2>& arrays, const Set& set) {
    std::array<Array, 2>& kept = (is_on_device ? on_device_ : kept_)[body];
    replaced_.reserve(replaced_.size() + 4);
    set(scene);
    if (!is_on_device) replace_on_device(body);
    kept.swap(arrays);
    if (is_on_device) std::move(arrays.begin(), arrays.end(), std::back_inserter(replaced_));
  }
  void count_body(std::uint64_t triangles) {
    ++body_count_;
    triangles_given_ += triangles;
  }

 private:
  /// So many pairs are compared within kSignalInterval. For less work, a thread of its own, 20 us, would be noticeable.
  static constexpr std::uint64_t kQuickWork = 1'000'000;

  using KeptArrays = std::map<std::uint32_t, std::array<Array, 2>>;
  using KeptPositions = std::multimap<std::uint32_t, std::array<Array, 2>>;

  void refuse_callbacks() const {
    if (user_ != std::this_thread::get_id()) return;
    throw Error("a pair filter or log callback must not call the scene or its queries.");
  }
  std::unique_lock<std::timed_mutex> lock_between_signals();
  void release_spent();
  template <class F>
  auto use(F& f) {
    const InUse in_use(user_);
    discarded_->give_back();
    return f(scene_);
  }

  /// Records which thread uses the scene.
  class InUse {
   public:
    explicit InUse(std::atomic<std::thread::id>& user) : user_(user) { user_ = std::this_thread::get_id(); }
    ~InUse() { user_ = std::thread::id(); }
    InUse(const InUse&) = delete;
    InUse& operator=(const InUse&) = delete;

   private:
    std::atomic<std::thread::id>& user_;
  };

  void log(LogLevel level, std::string_view text);
  void replace_on_device(std::uint32_t body);

  std::timed_mutex mutex_;
  std::atomic<std::thread::id> user_;
  nb::object log_;
  KeptArrays kept_;              ///< arrays that the next detection reads
  KeptArrays on_device_;         ///< arrays that any detection may read
  std::vector<Array> replaced_;  ///< former members of on_device_, kept until the next detection
  KeptPositions spent_;          ///< already read; released while the interpreter's lock is held
  std::vector<Array> spent_on_device_;
  std::shared_ptr<Discarded> discarded_ = std::make_shared<Discarded>();
  std::atomic<std::uint32_t> body_count_ = 0;
  std::atomic<std::uint64_t> triangles_given_ = 0;  ///< upper bound of the number of triangles
  Scene scene_;
};

}  // namespace softcd::python

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fuzzed_meshes.hpp"
#include "scene_model.hpp"
#include "softcd/fields/options.hpp"

// Whatever is called in whatever order, a scene gives the results of a new scene with the same state, and of brute
// force. A refused call throws an Error and changes nothing.
namespace softcd::test {
namespace {

constexpr int kMostCalls = 24;
constexpr std::size_t kMostBodies = 4;

/// Returns whether an Error is thrown. Any other exception ends the program.
template <class Expected = Error, class Call>
bool is_refused(const Call& call) {
  try {
    call();
  } catch (const Expected&) {
    return true;
  }
  return false;
}

bool is_valid(const BodyDesc& desc) {
  const auto has_vertices = [&](const Triangle& t) {
    return std::all_of(t.v, t.v + 3, [&](std::uint32_t v) { return v < desc.vertex_count; });
  };
  return std::all_of(desc.triangles.begin(), desc.triangles.end(), has_vertices) && problem_of(desc.settings).empty();
}

bool is_valid(const QueryOptions& o) {
  const bool looks_ahead = o.motion_margin > 0.0F && o.detection == Detection::dcd && o.step_end == StepEnd::t0;
  return problem_of(o).empty() && !looks_ahead;
}

template <class T>
bool are_same(Span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() && (b.empty() || std::memcmp(a.data(), b.data(), b.size() * sizeof(T)) == 0);
}

bool takes_third(BodyId a, BodyId b) {
  return (a.value + b.value) % 3 != 1;
}

/// A scene with a query and a probe, and the record of their calls.
class Session {
 public:
  explicit Session(Bytes& bytes) : bytes_(bytes) { renew(); }

  void run() {
    add_body();
    set_positions();
    for (int call = 0; call < kMostCalls && !bytes_.empty(); ++call) one_call();
    if (running_) wait();
    detect();
  }

 private:
  struct Running {
    Ticket ticket;
    std::optional<std::vector<Contact>> expected;  ///< nothing where it was ended
    QueryOptions options;
    SceneModel model;
    Pairs pairs;
    bool has_filter;
  };
  struct Held {
    std::shared_ptr<const void> holder;
    Span<const Contact> contacts;
    std::vector<Contact> copy;
  };
  using Memory = std::vector<std::byte>;

  void one_call() {
    switch (bytes_.below(14)) {
      case 0:
        return add_body();
      case 1:
        return update_body();
      case 2:
        return remove_body();
      case 3:
        return set_settings();
      case 4:
      case 5:
      case 6:
        return set_positions();
      case 7:
        return set_query_options();
      case 8:
        return set_scene_options();
      case 9:
        return running_ ? wait() : start();
      case 10:
        return set_filter();
      case 11:
        return ask_rays();
      case 12:
        return bytes_.one_in(8) ? renew() : ask_points();
      default:
        return detect();
    }
  }

  SceneOptions scene_options() {
    SceneOptions options;
    options.backend = Backend::cpu;
    options.max_threads = threads_;
    options.memory_limit = limit_;
    return options;
  }

  void renew() {
    model_.bodies.clear();
    options_ = {};
    filter_ = {};
    limit_ = 0;
    auto scene = std::make_unique<softcd::Scene>(scene_options());
    std::swap(scene, scene_);
    scene.reset();
    if (running_) wait_in_vain();
    if (query_) require(is_refused([&] { query_->detect(); }), "a query without a scene refuses");
    if (probe_) require(is_refused([&] { probe_->first_hits({}); }), "a probe without a scene refuses");
    query_.emplace(*scene_, options_);
    probe_.emplace(*scene_);
  }

  BodyId some_body() {
    if (model_.bodies.empty() || bytes_.one_in(40)) return BodyId{bytes_.take<std::uint8_t>()};
    return model_.bodies[bytes_.below(static_cast<std::uint32_t>(model_.bodies.size()))].id;
  }
  SceneModel::Body* find(BodyId id) {
    for (SceneModel::Body& body : model_.bodies) {
      if (body.id == id) return &body;
    }
    return nullptr;
  }

  SceneBody fuzzed_body() {
    SceneBody body;
    std::uint32_t vertex_count = 0;
    body.triangles = fuzzed_triangles(bytes_, &vertex_count);
    body.x_t0.resize(vertex_count);
    body.x_t1.resize(vertex_count);
    body.settings = fuzzed_settings(bytes_);
    return body;
  }
  static BodyDesc desc_of(const SceneBody& body) {
    return {body.triangles, static_cast<std::uint32_t>(body.x_t1.size()), body.settings};
  }

  void add_body() {
    if (model_.bodies.size() == kMostBodies) return;
    SceneBody body = fuzzed_body();
    BodyId id;
    const bool refused = is_refused<InvalidInput>([&] { id = scene_->add_body(desc_of(body)); });
    require(refused != is_valid(desc_of(body)), "meshes are refused where they are not valid");
    if (!refused) model_.bodies.push_back({id, std::move(body)});
  }

  void update_body() {
    const BodyId id = some_body();
    SceneBody body = fuzzed_body();
    const bool refused = is_refused<InvalidInput>([&] { scene_->update_body(id, desc_of(body)); });
    SceneModel::Body* known = find(id);
    require(refused != (known != nullptr && is_valid(desc_of(body))), "meshes are refused where they are not valid");
    if (!refused) *known = {id, std::move(body)};
  }

  void remove_body() {
    const BodyId id = some_body();
    const bool refused = is_refused<InvalidInput>([&] { scene_->remove_body(id); });
    require(refused == (find(id) == nullptr), "unknown bodies are refused");
    std::erase_if(model_.bodies, [&](const SceneModel::Body& body) { return body.id == id; });
    require(!scene_->has_body(id), "removed bodies are gone");
  }

  void set_settings() {
    const BodyId id = some_body();
    const BodySettings settings = fuzzed_settings(bytes_);
    const bool refused = is_refused<InvalidInput>([&] { scene_->set_settings(id, settings); });
    SceneModel::Body* known = find(id);
    require(refused != (known != nullptr && problem_of(settings).empty()), "settings are refused where not valid");
    if (!refused) known->mesh.settings = settings;
  }

  /// Copies positions to memory of the caller that is freed when the next detection has been started.
  template <class Scalar>
  Positions lend(const Positions3& x, std::size_t stride) {
    Memory memory(x.empty() ? 0 : (x.size() - 1) * stride + 3 * sizeof(Scalar));
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Scalar p[3] = {static_cast<Scalar>(x[i].x), static_cast<Scalar>(x[i].y), static_cast<Scalar>(x[i].z)};
      std::memcpy(memory.data() + i * stride, p, sizeof p);
    }
    lent_.push_back(std::move(memory));
    return {reinterpret_cast<const Scalar*>(lent_.back().data()), x.size(), stride};
  }
  Positions lend(const Positions3& x) {
    const std::size_t gap = bytes_.one_in(4) ? bytes_.below(64) : 0;
    return bytes_.below(2) == 0 ? lend<float>(x, 3 * sizeof(float) + gap) : lend<double>(x, 3 * sizeof(double) + gap);
  }

  void set_positions() {
    const BodyId id = some_body();
    SceneModel::Body* known = find(id);
    std::uint32_t count = known == nullptr ? 3 : static_cast<std::uint32_t>(known->mesh.x_t1.size());
    if (bytes_.one_in(60)) count += bytes_.below(3);
    const Positions3 x_t0 = fuzzed_positions(bytes_, count);
    const Positions3 x_t1 = fuzzed_motion(bytes_, x_t0);
    const Positions first = lend(x_t0);
    const Positions second = bytes_.one_in(8) ? lend(x_t1) : lend_as(x_t1, first);
    const bool refused = is_refused<InvalidInput>([&] { scene_->set_positions(id, first, second); });
    const bool fits = known != nullptr && known->mesh.x_t1.size() == count && is_aligned(first) && is_aligned(second) &&
                      first.is_double() == second.is_double();
    require(refused != fits, "positions are refused where they are not valid");
    if (refused) return;
    known->mesh.x_t0 = x_t0;
    known->mesh.x_t1 = x_t1;
    known->has_positions = true;
  }
  Positions lend_as(const Positions3& x, const Positions& other) {
    return other.is_double() ? lend<double>(x, other.stride()) : lend<float>(x, other.stride());
  }
  static bool is_aligned(const Positions& x) {
    return x.count() < 2 || x.stride() % (x.is_double() ? sizeof(double) : sizeof(float)) == 0;
  }

  void set_query_options() {
    const QueryOptions options = fuzzed_options(bytes_);
    const bool refused = is_refused<InvalidInput>([&] { query_->set_options(options); });
    require(refused != is_valid(options), "options are refused where they are not valid");
    if (refused) return;
    options_ = options;
    if (running_) running_->expected.reset();
  }

  void set_scene_options() {
    if (bytes_.one_in(8)) {
      SceneOptions refused = scene_options();
      refused.backend = static_cast<Backend>(2 + bytes_.below(100));  // there is no CUDA in these builds
      require(is_refused([&] { scene_->set_options(refused); }), "backends that cannot be had are refused");
      return;
    }
    threads_ = 1 + bytes_.below(3);
    limit_ = bytes_.one_in(3) ? std::uint64_t{1} << bytes_.below(24) : 0;
    scene_->set_options(scene_options());
    if (running_) running_->expected.reset();
  }

  void set_filter() {
    filter_ = bytes_.below(2) == 0 ? PairFilter() : takes_third;
    query_->set_pair_filter(filter_);
  }

  void start() {
    const Pairs pairs = bytes_.one_in(4) ? Pairs::changed : Pairs::all;
    running_.reset();
    std::vector<Contact> expected = model_.fresh_contacts(options_, filter_);
    try {
      running_.emplace(Running{query_->start(pairs), std::move(expected), options_, model_, pairs, bool(filter_)});
    } catch (const OutOfMemory&) {
      require(limit_ != 0, "memory suffices where it is not limited");
    }
    lent_.clear();
  }

  void wait_in_vain() {
    require(is_refused([&] { running_->ticket.wait(); }), "a detection that was ended has no contacts");
    running_.reset();
  }

  void wait() {
    if (!running_->expected) return wait_in_vain();
    Running done = std::move(*running_);
    running_.reset();
    Span<const Contact> contacts;
    try {
      contacts = done.ticket.wait();
    } catch (const OutOfMemory&) {
      require(limit_ != 0, "memory suffices where it is not limited");
      return;
    }
    require(is_refused([&] { done.ticket.wait(); }), "contacts are given once");
    const Statistics& statistics = query_->statistics();
    require(statistics.vt_contacts + statistics.ee_contacts == contacts.size(), "statistics count contacts");
    query_->explain();
    if (done.pairs == Pairs::changed) return require_part(contacts, *done.expected);
    require(identical(contacts, *done.expected), "the same input gives the same bytes");
    if (!done.has_filter) done.model.require_what_brute_force_finds(done.options, contacts);
    if (held_) require(identical(held_->contacts, held_->copy), "held contacts stay");
    if (bytes_.one_in(4)) held_ = {query_->hold_contacts(), contacts, {contacts.begin(), contacts.end()}};
  }

  static void require_part(Span<const Contact> contacts, const std::vector<Contact>& all) {
    for (const Contact& contact : contacts) {
      const auto is_this = [&](const Contact& other) { return std::memcmp(&contact, &other, sizeof contact) == 0; };
      require(std::any_of(all.begin(), all.end(), is_this), "contacts of what has changed are among all contacts");
    }
  }

  void detect() {
    start();
    if (running_) wait();
  }

  Vec3d fuzzed_point() { return fuzzed_positions(bytes_, 1)[0]; }

  void ask_rays() {
    std::vector<Ray> rays;
    for (std::uint32_t i = bytes_.below(4); i > 0; --i) {
      const Vec3d origin = fuzzed_point();
      rays.push_back({origin, fuzzed_point()});
    }
    try {
      const StepEnd end = probe_->options().step_end;
      const Span<const RayHit> found = probe_->first_hits(rays);
      const std::vector<RayHit> first(found.begin(), found.end());
      require(are_same(found, model_.fresh_hits(rays, end)), "the same rays give the same bytes");
      const AnswerLists<RayHit> all = probe_->all_hits(rays);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        require(first[i].has_hit() == !all[i].empty(), "a ray has a first hit where it has any");
        if (first[i].has_hit()) require(first[i].t == all[i][0].t, "the first hit is the first of all");
      }
      probe_->set_options({bytes_.one_in(3) ? StepEnd::t0 : StepEnd::t1});
    } catch (const OutOfMemory&) {
      require(limit_ != 0, "memory suffices where it is not limited");
    }
  }

  void ask_points() {
    std::vector<ProbePoint> points;
    for (std::uint32_t i = bytes_.below(4); i > 0; --i) points.push_back({fuzzed_point()});
    try {
      const StepEnd end = probe_->options().step_end;
      const Span<const ClosestPoint> found = probe_->closest_points(points);
      require(are_same(found, model_.fresh_closest_points(points, end)), "the same points give the same bytes");
      const std::vector<ClosestPoint> closest(found.begin(), found.end());
      std::vector<ProbeSphere> spheres;
      for (std::size_t i = 0; i < points.size(); ++i)
        spheres.push_back({points[i].point, 1.0001 * closest[i].distance});
      const AnswerLists<TriangleOverlap> overlaps = probe_->overlaps(spheres);
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!closest[i].has_point() || closest[i].distance == 0.0) continue;
        const auto is_nearest = [&](const TriangleOverlap& o) {
          return o.body == closest[i].body && o.triangle == closest[i].triangle;
        };
        require(std::any_of(overlaps[i].begin(), overlaps[i].end(), is_nearest), "what is nearest is near");
      }
    } catch (const OutOfMemory&) {
      require(limit_ != 0, "memory suffices where it is not limited");
    }
  }

  Bytes& bytes_;
  SceneModel model_;
  QueryOptions options_;
  PairFilter filter_;
  std::uint32_t threads_ = 1;
  std::uint64_t limit_ = 0;
  std::vector<Memory> lent_;
  std::unique_ptr<softcd::Scene> scene_;
  std::optional<Query> query_;
  std::optional<Probe> probe_;
  std::optional<Running> running_;
  std::optional<Held> held_;
};

}  // namespace
}  // namespace softcd::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  softcd::test::Bytes bytes(data, size);
  softcd::test::Session(bytes).run();
  return 0;
}

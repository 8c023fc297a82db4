#include "viewer/panel.hpp"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <type_traits>
#include <utility>

#include "softcd/fields/settings.hpp"
#include "softcd/pipeline/detector.hpp"

namespace softcd::demo {
namespace {

constexpr float kPlotHeight = 48;
constexpr ImGuiWindowFlags kFixed =
    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar;

void text(const std::string& line) {
  ImGui::TextUnformatted(line.c_str());
}

void note(const std::string& line) {
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::PushTextWrapPos(0);
  text(line);
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

bool begins_open(const char* title) {
  return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
}

void draw_run(const Session& session, PanelState& state) {
  if (ImGui::Button(state.is_paused ? "Go on" : "Pause")) state.is_paused = !state.is_paused;
  ImGui::SameLine();
  if (ImGui::Button("One step")) state.step_once = state.is_paused = true;
  ImGui::SameLine();
  if (ImGui::Button("Restart")) state.restart = true;
  ImGui::SameLine();
  text(fmt::format("{:.2f} s", double(session.scene().time())));
  ImGui::SetNextItemWidth(0.5F * kPanelWidth);
  ImGui::SliderInt("steps a frame", &state.steps_per_frame, 1, 8);
  if (ImGui::Button("Throw a ball")) state.throw_ball = true;
  ImGui::SameLine();
  if (ImGui::Button("Save a picture")) state.save_picture = true;
  if (!state.saved_picture.empty()) note("saved " + state.saved_picture);
}

void draw_scene_choice(const Session& session, PanelState& state) {
  if (!ImGui::BeginCombo("scene", session.scene_name().c_str())) return;
  for (const SceneInfo& scene : scenes()) {
    const bool is_open = scene.name == session.scene_name();
    if (ImGui::Selectable(scene.name, is_open) && !is_open) state.open_scene = scene.name;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", scene.description);
  }
  ImGui::EndCombo();
}

/// The detectors that can be switched between.
struct Detecting {
  const char* name;
  Collision collision;
  Backend backend;
};

/// Returns whether all settings are equal but for callbacks.
bool are_equal(const bullet::Settings& a, const bullet::Settings& b) {
  bool equal = true;
  for_each_field<bullet::Settings>([&](auto field) {
    using Value = typename decltype(field)::Value;
    if constexpr (std::is_enum_v<Value> || std::is_arithmetic_v<Value>) equal &= field.of(a) == field.of(b);
  });
  return equal;
}

void draw_presets(const Session& session, PanelState& state) {
  const bullet::Settings& settings = session.options().settings;
  for (const bullet::Preset& preset : bullet::kPresets) {
    bullet::Settings chosen = preset.value();
    chosen.backend = settings.backend;
    if (ImGui::RadioButton(preset.name, are_equal(chosen, settings))) {
      state.go_on_with = session.options();
      state.go_on_with->settings = chosen;
    }
    ImGui::SameLine();
  }
  text("preset");
}

template <class Value>
void draw_switch(const char* name, Value bullet::Settings::*dial, Value off, Value on, const Session& session,
                 PanelState& state) {
  bool is_on = session.options().settings.*dial == on;
  if (!ImGui::Checkbox(name, &is_on)) return;
  state.go_on_with = session.options();
  state.go_on_with->settings.*dial = is_on ? on : off;
}

void draw_settings(const Session& session, PanelState& state) {
  using bullet::Settings;
  draw_presets(session, state);
  draw_switch("ccd: along the whole step", &Settings::detection, Detection::dcd, Detection::ccd, session, state);
  draw_switch("edges respond", &Settings::edge_contacts, bullet::EdgeContacts::off, bullet::EdgeContacts::respond,
              session, state);
  if (session.options().world == World::classic) {
    draw_switch("one contact for each nearest place", &Settings::contacts, bullet::Contacts::all,
                bullet::Contacts::closest_feature, session, state);
  }
  draw_switch("faces and edges on convex shapes", &Settings::convex_shapes, bullet::ConvexShapes::nodes,
              bullet::ConvexShapes::faces_and_edges, session, state);
}

void draw_iterations(const Session& session, PanelState& state) {
  if (session.options().world != World::classic) return;
  int iterations = session.options().iterations;
  ImGui::SetNextItemWidth(0.5F * kPanelWidth);
  const char* const format = iterations == 0 ? "the scene's" : "%d";
  if (!ImGui::SliderInt("iterations", &iterations, 0, 20, format)) return;
  state.go_on_with = session.options();
  state.go_on_with->iterations = iterations;
}

/// The detectors, two a row.
constexpr std::array<Detecting, 4> kDetecting = {{{"off", Collision::off, Backend::automatic},
                                                  {"Bullet", Collision::bullet, Backend::automatic},
                                                  {"softcd, CPU", Collision::softcd, Backend::cpu},
                                                  {"softcd, CUDA", Collision::softcd, Backend::cuda}}};

bool is_current(const Detecting& detecting, const Session& session) {
  if (detecting.collision != session.options().collision) return false;
  const bullet::WorldDetection* detection = session.scene().simulation().detection();
  return detection == nullptr || detection->contact_report().backend() == detecting.backend;
}

void draw_detection(const Session& session, PanelState& state) {
  const std::string cuda_missing = cuda_problem();
  for (std::size_t i = 0; i < kDetecting.size(); ++i) {
    const Detecting& detecting = kDetecting[i];
    if (i % 2 == 1) ImGui::SameLine(kPanelWidth / 2.0F);
    const bool is_missing = detecting.backend == Backend::cuda && !cuda_missing.empty();
    ImGui::BeginDisabled(is_missing);
    if (ImGui::RadioButton(detecting.name, is_current(detecting, session))) {
      state.go_on_with = session.options();
      state.go_on_with->collision = detecting.collision;
      if (detecting.collision == Collision::softcd) state.go_on_with->settings.backend = detecting.backend;
    }
    ImGui::EndDisabled();
  }
  if (!cuda_missing.empty()) note("CUDA: " + cuda_missing);
  ImGui::BeginDisabled(session.options().collision != Collision::softcd);
  draw_settings(session, state);
  ImGui::EndDisabled();
  draw_iterations(session, state);
  if (!state.problem.empty()) note(state.problem);
}

void draw_plot(const char* name, const History& history, const std::string& now) {
  const auto& values = history.values();
  ImGui::PlotLines(name, values.data(), static_cast<int>(values.size()), 0, now.c_str(), 0, FLT_MAX,
                   ImVec2(ImGui::GetContentRegionAvail().x * 0.72F, kPlotHeight));
}

void draw_measurements(const Session& session, const DetectionGrid* grid, PanelState& state) {
  const bool is_softcd = session.scene().simulation().detection() != nullptr;
  const auto in_ms = [](const History& history) { return fmt::format("{:.2f} ms", double(history.last())); };
  draw_plot("step", session.step_ms(), in_ms(session.step_ms()));
  draw_plot("detection", session.detection_ms(), is_softcd ? in_ms(session.detection_ms()) : "not softcd's");
  text(fmt::format("contacts {}", session.scene().count_contacts()));
  if (ImGui::Button("Count penetrating vertices")) {
    state.penetrating = {session.scene().count_penetrating_vertices(), double(session.scene().time())};
  }
  if (state.penetrating) text(fmt::format("{} at {:.2f} s", state.penetrating->vertices, state.penetrating->time));
  if (grid == nullptr) return;
  const Statistics& counts = grid->counts();
  text(fmt::format("cells {}, entries {}, tests {}", counts.cells, counts.entries, counts.tests));
  text(fmt::format("cell size {:.4f}", counts.cell_size));
  text(fmt::format("split {}, children {}, big {}", counts.split_triangles, counts.children, counts.big_triangles));
}

void draw_legend(const DetectionGrid& grid) {
  std::uint64_t most = 0;
  for (const OccupiedCell& cell : grid.cells()) most = std::max(most, cell.tests);
  for (int quarter = 0; quarter <= 4; ++quarter) {  // of the range of colours
    const std::uint64_t tests = most * static_cast<std::uint64_t>(quarter * quarter) / 16;
    const Rgba color = color_of_tests(tests, most);
    ImGui::PushID(quarter);
    ImGui::ColorButton("tests", ImVec4(color[0] / 255.0F, color[1] / 255.0F, color[2] / 255.0F, 1),
                       ImGuiColorEditFlags_NoTooltip, ImVec2(12, 12));
    ImGui::PopID();
    ImGui::SameLine();
    text(std::to_string(tests));
    ImGui::SameLine();
  }
  text("tests");
}

void draw_contact_colors(OverlayChoice& overlays) {
  if (!overlays.contacts) return;
  constexpr std::array<std::pair<const char*, ContactColor>, 3> kColors = {
      {{"one colour", ContactColor::one}, {"depth", ContactColor::depth}, {"time", ContactColor::time_of_impact}}};
  for (const auto& [name, color] : kColors) {
    if (color != ContactColor::one) ImGui::SameLine();
    if (ImGui::RadioButton(name, overlays.contact_color == color)) overlays.contact_color = color;
  }
}

void draw_overlay_choice(const Session& session, const DetectionGrid* grid, PanelState& state) {
  ImGui::Checkbox("Edges of the triangles", &state.overlays.wire);
  ImGui::Checkbox("Contacts and normals", &state.overlays.contacts);
  ImGui::BeginDisabled(session.scene().simulation().detection() == nullptr);
  draw_contact_colors(state.overlays);
  ImGui::Checkbox("Grid cells by tests", &state.overlays.cells);
  ImGui::Checkbox("Children or cells of the picked triangle", &state.overlays.children);
  ImGui::Checkbox("Picked cell", &state.overlays.picked_cell);
  ImGui::EndDisabled();
  if (session.scene().simulation().detection() == nullptr) note("The grid is softcd's.");
  if (state.overlays.cells && grid != nullptr) draw_legend(*grid);
}

/// Returns the bits as text, from the lowest on: nine lower neighbours in the layer below, three in the row before, one
/// to the left.
std::string mask_text(std::uint32_t bits) {
  std::string text;
  for (std::uint32_t bit = 0; bit < GridEntry::kMaskBits; ++bit) {
    if (bit == 9 || bit == 12) text += ' ';
    text += ((bits >> bit) & 1U) != 0 ? '1' : '0';
  }
  return text;
}

std::string missing_text(std::uint32_t missing) {
  std::string text;
  for (const auto& [bit, name] : {std::pair{1U, 'x'}, {2U, 'y'}, {4U, 'z'}}) text += (missing & bit) != 0 ? name : '-';
  return text;
}

void draw_entries(const DetectionGrid& grid, const OccupiedCell& cell, std::uint32_t picked) {
  constexpr ImGuiTableFlags kStyle = ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY | ImGuiTableFlags_SizingFixedFit;
  if (!ImGui::BeginTable("entries", 4, kStyle, ImVec2(0, 200))) return;
  ImGui::TableSetupScrollFreeze(0, 1);
  for (const char* column : {"body", "triangle", "mask", "K"}) ImGui::TableSetupColumn(column);
  ImGui::TableHeadersRow();
  for (const GridEntry& entry : grid.entries(cell)) {
    const std::size_t body = grid.body_of(entry.triangle);
    ImGui::TableNextColumn();
    text(std::to_string(body));
    ImGui::TableNextColumn();
    text(fmt::format("{}{}", entry.triangle - grid.first_triangle(body), entry.triangle == picked ? " *" : ""));
    ImGui::TableNextColumn();
    text(mask_text(entry.mask));
    ImGui::TableNextColumn();
    text(missing_text(entry.missing));
  }
  ImGui::EndTable();
}

void draw_selection(const DetectionGrid* grid, const PanelState& state) {
  if (!state.selected) {
    note("Click on a triangle.");
    return;
  }
  text(fmt::format("body {}, triangle {}", state.selected->body, state.selected->face));
  if (grid == nullptr) return;
  const std::uint32_t triangle =
      grid->first_triangle(state.selected->body) + static_cast<std::uint32_t>(state.selected->face);
  const std::size_t children = grid->children_of(triangle).size();
  const std::size_t cells = grid->cells_of(triangle).size();
  text(children > 0 ? fmt::format("split into {} children, in {} cells", children, cells)
                    : fmt::format("not split, in {} cells", cells));
  const OccupiedCell* cell = grid->cell_around(triangle);
  if (cell == nullptr) {
    note("In no cell: what it may touch is out of reach, or it is so big that it is tested against all.");
    return;
  }
  text(fmt::format("picked cell: {} entries, {} tests", cell->entry_count, cell->tests));
  draw_entries(*grid, *cell, triangle);
  note(
      "mask: which of the cell's 13 lower neighbours (9 a layer below, 3 a row before, 1 to the left) hold the "
      "triangle too; a pair is tested where the masks share no bit. K: axes along which the neighbour does not.");
}

void draw_keys() {
  const ImVec2 corner(ImGui::GetIO().DisplaySize.x - 8, ImGui::GetIO().DisplaySize.y - 8);
  ImGui::SetNextWindowPos(corner, ImGuiCond_Always, ImVec2(1, 1));
  ImGui::SetNextWindowBgAlpha(0.55F);
  ImGui::Begin("Mouse and keys", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
  for (const char* line :
       {"left drag on a body     pull a node", "left click              pick a triangle",
        "left or right drag      turn the view", "middle or shift drag    move the view",
        "wheel                   nearer, further", "space                   pause, go on",
        "right arrow             one step", "R                       restart", "V                       first view",
        "B                       throw a ball", "P                       save a picture",
        "H                       hide the panels", "Esc                     close"}) {
    text(line);
  }
  ImGui::End();
}

}  // namespace

void draw_panel(const Session& session, const DetectionGrid* grid, PanelState& state) {
  ImGui::SetNextWindowPos(ImVec2(0, 0));
  ImGui::SetNextWindowSize(ImVec2(kPanelWidth, ImGui::GetIO().DisplaySize.y));
  ImGui::Begin("softcd", nullptr, kFixed);
  int triangles = 0;
  for (const btSoftBody* body : session.bodies()) triangles += body->m_faces.size();
  draw_scene_choice(session, state);
  text(fmt::format("{} triangles", triangles));
  draw_run(session, state);
  if (begins_open("Detection")) draw_detection(session, state);
  if (begins_open("Measurements")) draw_measurements(session, grid, state);
  if (begins_open("Overlays")) draw_overlay_choice(session, grid, state);
  if (begins_open("Picked")) draw_selection(grid, state);
  ImGui::End();
  draw_keys();
}

}  // namespace softcd::demo

// Settings::contacts and contacts_per_node choose contacts for Bullet's solver among those of Bullet's rule.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "exact_contacts.hpp"
#include "softcd/core/parallel.hpp"
#include "still_sheets.hpp"

namespace softcd::test {
namespace {

/// Contacts of one node with one body: the body of a face is that whose array has it.
struct Site {
  const btSoftBody::Node* node;
  const btSoftBody* body;

  friend bool operator<(const Site& a, const Site& b) { return std::tie(a.node, a.body) < std::tie(b.node, b.body); }
};
using Sites = std::map<Site, std::vector<SContact>>;

const btSoftBody* body_of(const btSoftBody::Face& face, const std::vector<btSoftBody*>& bodies) {
  for (const btSoftBody* body : bodies) {
    if (&face >= &body->m_faces[0] && &face < &body->m_faces[0] + body->m_faces.size()) return body;
  }
  ADD_FAILURE() << "a contact names a face of no body";
  return nullptr;
}

Sites sites_of(const std::vector<btSoftBody*>& bodies) {
  Sites sites;
  for (const btSoftBody* owner : bodies) {
    for (int i = 0; i < owner->m_scontacts.size(); ++i) {
      const SContact& contact = owner->m_scontacts[i];
      sites[{contact.m_node, body_of(*contact.m_face, bodies)}].push_back(contact);
    }
  }
  return sites;
}

/// Features at which the distance from the node has a minimum: no face at them is nearer by more than `slack`.
std::set<Feature> minima_of(const std::vector<SContact>& all, long double slack) {
  std::set<Feature> minima;
  for (const SContact& contact : all) {
    const Feature feature = feature_of(contact);
    const bool is_minimum = std::none_of(all.begin(), all.end(), [&](const SContact& other) {
      return has(*other.m_face, feature) && distance_of(other) < distance_of(contact) - slack;
    });
    if (is_minimum) minima.insert(feature);
  }
  return minima;
}

bool is_part_of(const Feature& a, const Feature& b) {
  return std::includes(b.begin(), b.end(), a.begin(), a.end());
}

/// One contact for each minimum, and no other but what pushes away from its nearer ones. Where a node is so nearly over
/// an edge or a corner that float cannot tell the distances apart, the feature may be the edge, the corner or a face
/// there.
void expect_minima(const std::vector<SContact>& all, const std::map<Feature, SContact>& chosen) {
  const std::set<Feature> possible = minima_of(all, kRounding);
  for (const auto& [feature, contact] : chosen) {
    const bool faces_another = std::any_of(chosen.begin(), chosen.end(), [&, &mine = contact](const auto& other) {
      return other.second.m_normal.dot(mine.m_normal) <= 0 && distance_of(other.second) <= distance_of(mine);
    });
    EXPECT_TRUE(possible.count(feature) > 0 || faces_another);
  }
  for (const Feature& minimum : minima_of(all, 1e-13L)) {
    EXPECT_TRUE(std::any_of(chosen.begin(), chosen.end(), [&](const auto& choice) {
      return is_part_of(choice.first, minimum) || is_part_of(minimum, choice.first);
    }));
  }
}

/// Judges what two worlds in the same state were given.
struct Given {
  Still all, chosen;
  Sites all_sites, chosen_sites;

  template <class Build>
  Given(const bullet::Settings& settings, Build build) : all(settings_choosing(Contacts::all)), chosen(settings) {
    for (Still* still : {&all, &chosen}) {
      build(*still);
      still->step();
    }
    all_sites = sites_of(all.bodies());
    chosen_sites = sites_of(chosen.bodies());
  }

  /// The same nodes in the world with all contacts.
  Feature in_all(const Feature& feature) const {
    Feature twins;
    for (std::size_t b = 0; b < all.bodies().size(); ++b) {
      btSoftBody::tNodeArray& nodes = chosen.bodies()[b]->m_nodes;
      for (const btSoftBody::Node* node : feature) {
        if (node < &nodes[0] || node >= &nodes[0] + nodes.size()) continue;
        twins.insert(&all.bodies()[b]->m_nodes[static_cast<int>(node - &nodes[0])]);
      }
    }
    return twins;
  }

  /// Returns the chosen contacts at a site of the world with all contacts.
  std::vector<SContact> chosen_at(const Site& site) const {
    for (std::size_t b = 0; b < all.bodies().size(); ++b) {
      const btSoftBody& owner = *all.bodies()[b];
      if (site.node < &owner.m_nodes[0] || site.node >= &owner.m_nodes[0] + owner.m_nodes.size()) continue;
      const auto body = std::find(all.bodies().begin(), all.bodies().end(), site.body) - all.bodies().begin();
      const Site twin{&chosen.bodies()[b]->m_nodes[static_cast<int>(site.node - &owner.m_nodes[0])],
                      chosen.bodies()[static_cast<std::size_t>(body)]};
      const auto found = chosen_sites.find(twin);
      return found == chosen_sites.end() ? std::vector<SContact>() : found->second;
    }
    return {};
  }
};

long double nearest_of(const std::vector<SContact>& contacts) {
  long double nearest = 1e9L;
  for (const SContact& contact : contacts) nearest = std::min(nearest, distance_of(contact));
  return nearest;
}

std::vector<const char*> build_names() {
  return {"bumps on bumps", "bumps on a plane", "nodes over corners", "nodes over edges", "between layers"};
}

/// Adds bodies to be judged, which do not intersect. Where there is chance in their state, each seed makes another one.
void build(Still& still, const std::string& name, std::uint64_t seed) {
  Random random(seed);
  if (name == "bumps on bumps" || name == "bumps on a plane") {
    still.add(name == "bumps on bumps" ? bumpy(0, btScalar(0.03), random) : flat(0));
    still.add(bumpy(btScalar(0.061), btScalar(0.03), random));
  } else if (name == "between layers") {
    still.add(folded(btScalar(0.12)));
    constexpr btScalar kBump = btScalar(0.03);
    demo::ClothShape sheet = bumpy(btScalar(0.06), kBump, random);
    sheet.position = [on = sheet.position](int column, int row) {
      return on(column, row) + btVector3(2 * kBump, 0, 0);  // off the bend
    };
    still.add(sheet);
  } else {
    still.add(flat(0));
    still.add(flat(btScalar(0.0625), name == "nodes over edges" ? kCell / 2 : 0));
  }
}

TEST(ContactEconomy, gives_one_contact_for_each_place_that_is_nearest) {
  std::size_t chosen_count = 0, all_count = 0;
  for (const std::string name : build_names()) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      const Given given(settings_choosing(Contacts::closest_feature), [&](Still& still) { build(still, name, seed); });
      ASSERT_FALSE(given.all_sites.empty());
      for (const auto& [site, contacts] : given.all_sites) {
        const std::vector<SContact> chosen = given.chosen_at(site);
        EXPECT_NEAR(double(nearest_of(chosen)), double(nearest_of(contacts)), double(kRounding));
        std::map<Feature, SContact> features;
        for (const SContact& contact : chosen) features.emplace(given.in_all(feature_of(contact)), contact);
        EXPECT_EQ(features.size(), chosen.size()) << "a feature has two contacts";
        expect_minima(contacts, features);
        chosen_count += chosen.size();
        all_count += contacts.size();
      }
    }
  }
  EXPECT_LT(chosen_count, all_count / 2) << "the scenes have little to choose from";
}

TEST(ContactEconomy, a_contact_answers_for_those_that_it_stands_for) {
  const auto corners = [](Still& still) { build(still, "nodes over corners", 1); };
  const Given given(settings_choosing(Contacts::closest_feature), corners);
  for (const auto& [site, contacts] : given.all_sites) {
    const std::vector<SContact> chosen = given.chosen_at(site);
    ASSERT_EQ(chosen.size(), 1U);
    const SContact& first = contacts.front();
    EXPECT_EQ(chosen[0].m_normal, first.m_normal);
    EXPECT_EQ(chosen[0].m_weights, first.m_weights);
    EXPECT_EQ(chosen[0].m_margin, first.m_margin);
    EXPECT_EQ(chosen[0].m_cfm[0], first.m_cfm[0]);
    EXPECT_EQ(chosen[0].m_cfm[1], first.m_cfm[1]);
    const double left = std::pow(1 - double(first.m_friction), double(contacts.size()));
    EXPECT_NEAR(double(chosen[0].m_friction), 1 - left, 1e-6);
  }
}

TEST(ContactEconomy, a_node_between_layers_of_one_body_is_held_by_both) {
  for (const std::uint32_t per_node : {0U, 1U}) {
    for (const Contacts rule : {Contacts::all, Contacts::closest_feature}) {
      if (rule == Contacts::all && per_node == 0) continue;
      Still still(settings_choosing(rule, per_node));
      still.add(folded(btScalar(0.12)));
      btSoftBody& between = still.add(flat(btScalar(0.0625), kCell / 4));
      still.step();
      const Sites sites = sites_of(still.bodies());
      for (int row = 0; row < kNodes - 1; ++row) {
        for (int column = 1; column < kNodes - 1; ++column) {  // the first is at the bend, too
          const auto site = sites.find({&between.m_nodes[row * kNodes + column], still.bodies()[0]});
          ASSERT_NE(site, sites.end());
          ASSERT_EQ(site->second.size(), 2U) << per_node;
          EXPECT_LT(site->second[0].m_normal.dot(site->second[1].m_normal), btScalar(-0.99));
        }
      }
    }
  }
}

TEST(ContactEconomy, a_bound_leaves_the_nearest_on_each_side) {
  std::size_t dropped = 0;
  for (const std::uint32_t most : {1U, 2U, 3U}) {
    for (const std::string name : build_names()) {
      const Given given(settings_choosing(Contacts::all, most), [&](Still& still) { build(still, name, 7); });
      for (const auto& [site, contacts] : given.all_sites) {
        const std::vector<SContact> chosen = given.chosen_at(site);
        ASSERT_FALSE(chosen.empty()) << name;
        EXPECT_NEAR(double(nearest_of(chosen)), double(nearest_of(contacts)), double(kRounding));
        for (const SContact& contact : contacts) {
          const auto count = std::count_if(chosen.begin(), chosen.end(), [&](const SContact& other) {
            return other.m_normal.dot(contact.m_normal) > 0 && distance_of(other) <= distance_of(contact) + kRounding;
          });
          const bool is_given = std::any_of(chosen.begin(), chosen.end(), [&](const SContact& other) {
            return other.m_normal == contact.m_normal && other.m_weights == contact.m_weights;
          });
          EXPECT_TRUE(is_given || count >= static_cast<std::ptrdiff_t>(most)) << name << ", " << most;
        }
        dropped += contacts.size() - chosen.size();
      }
    }
  }
  EXPECT_GT(dropped, 0U);
}

TEST(ContactEconomy, depends_neither_on_threads_nor_on_the_way_in) {
  const auto contacts_with = [](std::size_t threads, PlugIn plug_in) {
    const parallel::ThreadLimit limit(threads);
    Still still(settings_choosing(Contacts::closest_feature), plug_in);
    Random random(3);
    for (int i = 0; i < 12; ++i) still.add(bumpy(btScalar(0.03) * btScalar(i), btScalar(0.04), random));
    still.step();
    std::vector<std::tuple<int, long, long, btScalar, btScalar, btScalar>> contacts;
    for (const btSoftBody* body : still.bodies()) {
      for (int i = 0; i < body->m_scontacts.size(); ++i) {
        const SContact& contact = body->m_scontacts[i];
        const btSoftBody& other = *body_of(*contact.m_face, still.bodies());
        contacts.emplace_back(i, contact.m_node - &body->m_nodes[0], contact.m_face - &other.m_faces[0],
                              contact.m_weights.x(), contact.m_normal.y(), contact.m_friction);
      }
    }
    return contacts;
  };
  const auto one = contacts_with(1, PlugIn::one_line_world);
  EXPECT_GT(one.size(), 2000U) << "too few to be shared by threads";
  EXPECT_EQ(contacts_with(2, PlugIn::one_line_world), one);
  EXPECT_EQ(contacts_with(7, PlugIn::dispatcher), one);
  EXPECT_EQ(contacts_with(3, PlugIn::multi_body_world), one);
}

TEST(ContactEconomy, is_explained) {
  const auto last_line = [](Still& still) { return still.simulation().detection()->contact_report().explain().back(); };
  Still all(settings_choosing(Contacts::all));
  build(all, "nodes over corners", 1);
  all.step();
  EXPECT_EQ(last_line(all).stage, DetectionStage::contact_economy);
  EXPECT_FALSE(last_line(all).ran);
  EXPECT_EQ(bullet::Settings().contacts, Contacts::automatic);
  Still chosen(settings_choosing(Contacts::closest_feature));
  build(chosen, "nodes over corners", 1);
  chosen.step();
  EXPECT_TRUE(last_line(chosen).ran);
  EXPECT_NE(last_line(chosen).reason.find(" 162 of "), std::string::npos) << last_line(chosen).reason;
}

// Nodes that pass through both layers of a fold in one step: each has the contact with the layer that it meets first.
TEST(ContactEconomy, a_bound_leaves_what_is_met_first) {
  bullet::Settings settings = settings_choosing(Contacts::all, 1);
  settings.detection = Detection::ccd;
  constexpr btScalar kGap = btScalar(0.4);
  Still still(settings);
  const btSoftBody& fold = still.add(folded(kGap));
  std::set<const btSoftBody::Node*> upper;
  for (int i = 0; i < fold.m_nodes.size(); ++i) {
    if (fold.m_nodes[i].m_x.y() > kGap / 2) upper.insert(&fold.m_nodes[i]);
  }
  btSoftBody& falling = still.add(flat(btScalar(0.6)));
  falling.setVelocity(btVector3(0, btScalar(-0.9) / kStep, 0));
  falling.m_cfg.kDP = 0;
  still.step();
  ASSERT_GT(falling.m_scontacts.size(), 20);
  for (int i = 0; i < falling.m_scontacts.size(); ++i) {
    const SContact& contact = falling.m_scontacts[i];
    const bool is_at_bend = contact.m_node->m_q.x() < kCell / 2;
    EXPECT_TRUE(is_at_bend || upper.contains(contact.m_face->m_n[0])) << i;
  }
}

}  // namespace
}  // namespace softcd::test

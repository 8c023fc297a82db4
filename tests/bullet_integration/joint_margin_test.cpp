// The margin with which one classic contact replaces several, compared with Bullet's own solver.

#include "contacts/joint_margin.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "bodies/vectors.hpp"
#include "random.hpp"
#include "scenes/cloth.hpp"
#include "softcd/math/closest_point.hpp"

namespace softcd::test {
namespace {

using SContact = btSoftBody::SContact;

constexpr btScalar kMarginOfBoth = btScalar(0.06);
constexpr btScalar kClothCell = btScalar(0.1);
constexpr double kPushRounding = 2e-6;  // of positions of the size of one, moved a few dozen times in float

/// A node over the middle of a rough cloth of 4 * 4 nodes, and the contacts that Bullet's rule has for it. The node
/// moves a little. If the cloth is free, its nodes move as well, and all contacts are at the nearest face's point, with
/// normals that differ: joint_margin() takes the faces of several contacts for one.
class NodeOverCloth {
 public:
  NodeOverCloth(Random& random, bool is_fixed) {
    demo::ClothShape shape;
    shape.columns = shape.rows = 4;
    shape.position = [&](int column, int row) {
      return kClothCell * btVector3(btScalar(column), 0, btScalar(row)) + anywhere(random, 0.01);
    };
    if (is_fixed) shape.is_fixed = [](int, int) { return true; };
    cloth_ = demo::make_cloth(world_info_, shape, 1);
    if (!is_fixed) move(*cloth_, random);
    const btVector3 above = kClothCell * btVector3(btScalar(1.5), 0, btScalar(1.5)) +
                            btVector3(0, btScalar(random.uniform(0.03, 0.09)), 0) + anywhere(random, 0.03);
    const btScalar mass = btScalar(random.uniform(0.01, 0.2));
    node_ = std::make_unique<btSoftBody>(&world_info_, 1, &above, &mass);
    move(*node_, random);
    node_->m_nodes[0].m_q += btVector3(0, btScalar(0.01), 0);  // downwards, most of them
    for (int i = 0; i < cloth_->m_faces.size(); ++i) add_contact(cloth_->m_faces[i]);
    for (std::size_t i = 1; i < contacts_.size(); ++i) {
      if (separation(contacts_[i]) < separation(contacts_[nearest_])) nearest_ = i;
    }
    if (is_fixed || contacts_.empty()) return;
    const SContact nearest = contacts_[nearest_];
    for (SContact& contact : contacts_) {
      contact = nearest;
      contact.m_normal = (nearest.m_normal + anywhere(random, 0.5)).normalized();
    }
    contacts_[nearest_] = nearest;
  }

  const std::vector<SContact>& contacts() const { return contacts_; }
  const SContact& nearest() const { return contacts_[nearest_]; }
  std::size_t nearest_place() const { return nearest_; }

  /// How far Bullet's solver moves the node from the nearest face with these contacts. All is put back.
  double push_of(const std::vector<SContact>& contacts, int rounds) {
    const std::vector<btVector3> before[2] = {positions(*node_), positions(*cloth_)};
    const btScalar start = separation(nearest());
    node_->m_scontacts.resize(0);
    for (const SContact& contact : contacts) node_->m_scontacts.push_back(contact);
    for (int round = 0; round < rounds; ++round) btSoftBody::PSolve_SContacts(node_.get(), 1, 0);
    const btScalar push = separation(nearest()) - start;
    put_back(*node_, before[0]);
    put_back(*cloth_, before[1]);
    return double(push);
  }

 private:
  static btVector3 anywhere(Random& random, double half_size) { return bullet::to_bullet(random.in_box(half_size)); }

  static void move(btSoftBody& body, Random& random) {
    for (int i = 0; i < body.m_nodes.size(); ++i) body.m_nodes[i].m_q = body.m_nodes[i].m_x + anywhere(random, 0.01);
  }

  static std::vector<btVector3> positions(const btSoftBody& body) {
    std::vector<btVector3> all;
    for (int i = 0; i < body.m_nodes.size(); ++i) all.push_back(body.m_nodes[i].m_x);
    return all;
  }

  static void put_back(btSoftBody& body, const std::vector<btVector3>& to) {
    for (int i = 0; i < body.m_nodes.size(); ++i) body.m_nodes[i].m_x = to[static_cast<std::size_t>(i)];
  }

  static btScalar separation(const SContact& contact) {
    btVector3 apart = contact.m_node->m_x;
    for (int i = 0; i < 3; ++i) apart -= contact.m_weights[i] * contact.m_face->m_n[i]->m_x;
    return apart.dot(contact.m_normal);
  }

  /// Adds a contact by the formulas of Bullet's CollideVF_SS.
  void add_contact(btSoftBody::Face& face) {
    btSoftBody::Node& node = node_->m_nodes[0];
    const auto corner = [&](int i) { return bullet::to_doubles(face.m_n[i]->m_x); };
    const auto closest = closest_points_vertex_triangle(bullet::to_doubles(node.m_x), corner(0), corner(1), corner(2));
    SContact contact;
    contact.m_node = &node;
    contact.m_face = &face;
    contact.m_margin = kMarginOfBoth + 2 * (node.m_x - node.m_q).length();
    if (closest.distance() > double(contact.m_margin)) return;
    btVector3 apart = node.m_x;
    btScalar face_inverse_mass = 0;
    for (int i = 0; i < 3; ++i) {
      contact.m_weights[i] = btScalar(closest.weights[i + 1]);
      apart -= contact.m_weights[i] * face.m_n[i]->m_x;
      face_inverse_mass += contact.m_weights[i] * face.m_n[i]->m_im;
    }
    contact.m_normal = apart.normalized();
    contact.m_friction = btScalar(0.2);
    contact.m_cfm[0] = node.m_im / (node.m_im + face_inverse_mass);
    contact.m_cfm[1] = face_inverse_mass / (node.m_im + face_inverse_mass);
    contacts_.push_back(contact);
  }

  btSoftBodyWorldInfo world_info_;
  std::unique_ptr<btSoftBody> cloth_, node_;
  std::vector<SContact> contacts_;
  std::size_t nearest_ = 0;
};

// Or until the approach has ended, where several leave some of it.
TEST(JointMargin, one_contact_pushes_as_bullets_solver_does_for_several) {
  Random random(1);
  for (const int rounds : {1, 4}) {
    for (const bool is_fixed : {true, false}) {
      SCOPED_TRACE(testing::Message() << rounds << " rounds, " << (is_fixed ? "fixed" : "free"));
      int equal = 0, less = 0;
      for (int i = 0; i < 400; ++i) {
        NodeOverCloth scene(random, is_fixed);
        if (scene.contacts().empty()) continue;
        SContact one = scene.nearest();
        one.m_margin = bullet::joint_margin(scene.contacts(), scene.nearest_place(), rounds);
        const double approach = std::max(0.0, double(bullet::approach_of(scene.nearest())));
        const double expected = std::max(approach, scene.push_of(scene.contacts(), rounds));
        if (one.m_margin < scene.nearest().m_margin) {
          EXPECT_NEAR(scene.push_of({one}, rounds), expected, kPushRounding) << i;
          ++equal;
        } else {
          EXPECT_EQ(one.m_margin, scene.nearest().m_margin);
          EXPECT_LE(scene.push_of({one}, rounds), expected + kPushRounding) << i;
          ++less;
        }
      }
      EXPECT_GT(equal, 100);
      EXPECT_GT(less, 10);
    }
  }
}

TEST(JointMargin, is_the_contacts_own_where_the_node_moves_away) {
  Random random(2);
  int away = 0;
  for (int i = 0; i < 100; ++i) {
    NodeOverCloth scene(random, /*is_fixed=*/true);
    if (scene.contacts().empty()) continue;
    SContact one = scene.nearest();
    one.m_node->m_q = one.m_node->m_x - btScalar(0.01) * one.m_normal;
    EXPECT_EQ(bullet::joint_margin(scene.contacts(), scene.nearest_place(), 4), one.m_margin);
    ++away;
  }
  EXPECT_GT(away, 20);
}

}  // namespace
}  // namespace softcd::test

#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <utility>
#include <vector>

#include "BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h"
#include "BulletSoftBody/btSoftBodyData.h"
#include "LinearMath/btIDebugDraw.h"
#include "LinearMath/btSerializer.h"

/// Bullet's serialized data and debug drawing of a world.
namespace softcd::test {

struct SavedWorld {
  std::vector<std::pair<int, int>> chunks;  ///< code and length
  std::vector<int> collision_flags;         ///< of soft bodies
};

inline SavedWorld save(btDiscreteDynamicsWorld& world) {
  btDefaultSerializer serializer;
  world.serialize(&serializer);
  SavedWorld saved;
  const unsigned char* at = serializer.getBufferPointer() + BT_HEADER_LENGTH;
  const unsigned char* end = serializer.getBufferPointer() + serializer.getCurrentBufferSize();
  while (at < end) {
    btChunk chunk;
    std::memcpy(&chunk, at, sizeof(chunk));
    at += sizeof(chunk);
    saved.chunks.emplace_back(chunk.m_chunkCode, chunk.m_length);
    if (chunk.m_chunkCode == BT_SOFTBODY_CODE) {
      btSoftBodyData body;
      std::memcpy(&body, at, sizeof(body));
      saved.collision_flags.push_back(body.m_config.m_collisionFlags);
    }
    at += chunk.m_length;
  }
  return saved;
}

class LineCounter : public btIDebugDraw {
 public:
  int lines = 0;
  void drawLine(const btVector3&, const btVector3&, const btVector3&) override { ++lines; }
  void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override { ++lines; }
  void draw3dText(const btVector3&, const char*) override { ++lines; }
  void reportErrorWarning(const char* message) override { ADD_FAILURE() << message; }
  void setDebugMode(int) override {}
  int getDebugMode() const override {
    return DBG_DrawWireframe | DBG_DrawAabb | DBG_DrawContactPoints | DBG_DrawNormals;
  }
};

/// With the flags that the world has.
inline int lines_drawn(btDiscreteDynamicsWorld& world) {
  LineCounter counter;
  world.setDebugDrawer(&counter);
  world.debugDrawWorld();
  world.setDebugDrawer(nullptr);
  return counter.lines;
}

}  // namespace softcd::test

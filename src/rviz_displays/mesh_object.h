#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>
#include <OgreSceneNode.h>
#include <OgreSimpleRenderable.h>

#include "scene/flat_mesh.h"

namespace hymm {

/// A material that shows its colours as they are, from both sides, blended by their opacity.
Ogre::MaterialPtr makeFlatMaterial();

/// Triangles or lines at a height over the plane of a node. Positions, colours and texture
/// coordinates have a buffer each: whoever moves the corners rewrites nothing else.
class MeshObject : public Ogre::SimpleRenderable {
 public:
  enum class Kind { kTriangles, kLines };

  /// Hangs on `node`, which outlives it. What has the larger `queue` is drawn over the other.
  MeshObject(Ogre::SceneNode* node, Kind kind, Ogre::MaterialPtr material, int queue);
  ~MeshObject() override;
  MeshObject(const MeshObject&) = delete;
  MeshObject& operator=(const MeshObject&) = delete;

  /// Everything anew, at `height_m`.
  void show(const core::FlatVertices& vertices, float height_m);
  void clear();

  void setPositions(const std::vector<Eigen::Vector2f>& positions, float height_m);
  void setColours(const std::vector<core::Pixel>& colours);
  void setTextureCoordinates(const std::vector<Eigen::Vector2f>& coordinates);

  Ogre::Real getBoundingRadius() const override { return radius_; }
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override;
  void _updateRenderQueue(Ogre::RenderQueue* queue) override;

 private:
  /// Fills the buffer of `source`, a new one if it has another number of corners.
  void fill(unsigned short source, Ogre::VertexElementType type,
            Ogre::VertexElementSemantic semantic, const void* data, std::size_t count);

  Ogre::SceneNode* node_;
  Ogre::Real radius_ = 0.0F;
};

}  // namespace hymm

#include "rviz_displays/mesh_object.h"

#include <algorithm>
#include <utility>

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgreMaterialManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>

namespace hymm {
namespace {

// Buffers of the vertex declaration.
constexpr unsigned short kPositions = 0, kColours = 1, kTextureCoordinates = 2;

}  // namespace

Ogre::MaterialPtr makeFlatMaterial() {
  static int count = 0;
  Ogre::MaterialPtr material = Ogre::MaterialManager::getSingleton().create(
      "hymm flat material " + std::to_string(count++),
      Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  material->setReceiveShadows(false);
  material->setLightingEnabled(false);
  material->setCullingMode(Ogre::CULL_NONE);
  material->setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  material->setDepthWriteEnabled(false);
  return material;
}

MeshObject::MeshObject(Ogre::SceneNode* node, Kind kind, Ogre::MaterialPtr material, int queue)
    : node_(node) {
  mRenderOp.vertexData = new Ogre::VertexData();
  mRenderOp.operationType = kind == Kind::kLines ? Ogre::RenderOperation::OT_LINE_LIST
                                                 : Ogre::RenderOperation::OT_TRIANGLE_LIST;
  mRenderOp.useIndexes = false;
  setMaterial(material);
  setRenderQueueGroup(static_cast<Ogre::uint8>(queue));
  setCastShadows(false);
  node_->attachObject(this);
}

MeshObject::~MeshObject() {
  node_->detachObject(this);
  delete mRenderOp.vertexData;
}

void MeshObject::show(const core::FlatVertices& vertices, float height_m) {
  setColours(vertices.colours);
  setPositions(vertices.positions, height_m);
}

void MeshObject::clear() { mRenderOp.vertexData->vertexCount = 0; }

void MeshObject::setPositions(const std::vector<Eigen::Vector2f>& positions, float height_m) {
  std::vector<Eigen::Vector3f> corners;
  corners.reserve(positions.size());
  Ogre::AxisAlignedBox box;
  Ogre::Real radius = 0.0F;
  for (const Eigen::Vector2f& p : positions) {
    corners.emplace_back(p.x(), p.y(), height_m);
    box.merge(Ogre::Vector3(p.x(), p.y(), height_m));
    radius = std::max(radius, corners.back().norm());
  }
  fill(kPositions, Ogre::VET_FLOAT3, Ogre::VES_POSITION, corners.data(), corners.size());
  mRenderOp.vertexData->vertexCount = positions.size();
  radius_ = radius;
  setBoundingBox(box);
  node_->needUpdate();
}

void MeshObject::setColours(const std::vector<core::Pixel>& colours) {
  fill(kColours, Ogre::VET_UBYTE4_NORM, Ogre::VES_DIFFUSE, colours.data(), colours.size());
}

void MeshObject::setTextureCoordinates(const std::vector<Eigen::Vector2f>& coordinates) {
  fill(kTextureCoordinates, Ogre::VET_FLOAT2, Ogre::VES_TEXTURE_COORDINATES, coordinates.data(),
       coordinates.size());
}

void MeshObject::fill(unsigned short source, Ogre::VertexElementType type,
                      Ogre::VertexElementSemantic semantic, const void* data, std::size_t count) {
  Ogre::VertexDeclaration& declaration = *mRenderOp.vertexData->vertexDeclaration;
  Ogre::VertexBufferBinding& binding = *mRenderOp.vertexData->vertexBufferBinding;
  if (declaration.findElementBySemantic(semantic) == nullptr) {
    declaration.addElement(source, 0, type, semantic);
  }
  if (count == 0) return;
  const std::size_t size = Ogre::VertexElement::getTypeSize(type);
  if (!binding.isBufferBound(source) || binding.getBuffer(source)->getNumVertices() != count) {
    binding.setBinding(source,
                       Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
                           size, count, Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY_DISCARDABLE));
  }
  binding.getBuffer(source)->writeData(0, size * count, data, true);
}

Ogre::Real MeshObject::getSquaredViewDepth(const Ogre::Camera* camera) const {
  return (node_->convertLocalToWorldPosition(mBox.isFinite() ? mBox.getCenter()
                                                             : Ogre::Vector3::ZERO) -
          camera->getDerivedPosition())
      .squaredLength();
}

void MeshObject::_updateRenderQueue(Ogre::RenderQueue* queue) {
  if (mRenderOp.vertexData->vertexCount > 0) SimpleRenderable::_updateRenderQueue(queue);
}

}  // namespace hymm

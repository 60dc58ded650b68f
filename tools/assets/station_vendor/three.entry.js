export {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, GLSL3, Group, HemisphereLight, Line,
  LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Points,
  Quaternion, RawShaderMaterial, Scene, Sphere, Vector3, WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/addons/controls/OrbitControls.js';
export { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

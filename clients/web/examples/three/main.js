// The sea of a Swellcast server in a scene of three.js, with a buoy afloat in it.
// ?url= is the address of another server, which has to allow this page: swellcast serve --allow-origin ORIGIN
// ?low spares a weak GPU.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { connect } from '@swellcast/client';
import { Sea, Sky } from '@swellcast/client/three';

const RADIUS = 1.4; // metres, of the buoy

const query = new URLSearchParams(location.search), low = query.has('low');
const client = connect(query.get('url') ?? location.origin);
const renderer = new THREE.WebGLRenderer({ antialias: !low, powerPreference: 'high-performance' });
renderer.toneMapping = THREE.ACESFilmicToneMapping;
renderer.setPixelRatio(Math.min(2, devicePixelRatio));
document.body.append(renderer.domElement);

const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(55, 1, 0.3, 40_000);
camera.position.set(9, 3.5, 12);
const controls = new OrbitControls(camera, renderer.domElement);
controls.target.set(0, 1.5, 0);
controls.maxPolarAngle = 0.52 * Math.PI;

const sea = new Sea(client, renderer, { low });
sea.sun.set(-1, 0.4, -0.1).normalize();
const light = new THREE.DirectionalLight(sea.colors.sun);
light.position.copy(sea.sun);
const buoy = makeBuoy();
scene.add(sea, new Sky(sea), light, new THREE.HemisphereLight(sea.colors.horizon, sea.colors.water, 2), buoy);

function makeBuoy() {
  const paint = (color) => new THREE.MeshStandardMaterial({ color, roughness: 0.5 });
  const part = (geometry, color, y) => {
    const mesh = new THREE.Mesh(geometry, paint(color));
    mesh.position.y = y;
    return mesh;
  };
  return new THREE.Group().add(
    part(new THREE.CylinderGeometry(RADIUS, 0.8 * RADIUS, 1, 32), '#d9361e', 0.1),
    part(new THREE.CylinderGeometry(0.1, 0.5, 2.4, 16), '#f0b21a', 1.7),
    part(new THREE.SphereGeometry(0.25, 16, 16), '#f6f2e6', 3.1),
  );
}

const east = new THREE.Vector3(), south = new THREE.Vector3(), up = new THREE.Vector3(), turn = new THREE.Matrix4();

/** Heave and tilt: the height of the water below, and the plane through four points about it. */
function float() {
  const at = (x, z) => sea.heightAt(x, z), y = at(0, 0);
  buoy.visible = Number.isFinite(y);
  if (!buoy.visible) return;
  buoy.position.y = y;
  east.set(2 * RADIUS, at(RADIUS, 0) - at(-RADIUS, 0), 0).normalize();
  south.set(0, at(0, RADIUS) - at(0, -RADIUS), 2 * RADIUS);
  up.crossVectors(south, east).normalize();
  buoy.quaternion.setFromRotationMatrix(turn.makeBasis(east, up, south.crossVectors(east, up)));
}

function fit() {
  camera.aspect = innerWidth / innerHeight;
  camera.updateProjectionMatrix();
  renderer.setSize(innerWidth, innerHeight);
}

function paint(now) {
  controls.update();
  sea.update(now, camera);
  float();
  renderer.render(scene, camera);
}

fit();
addEventListener('resize', fit);
renderer.setAnimationLoop(paint);
document.addEventListener('visibilitychange', () => client.pause(document.hidden));
Object.assign(window, { client, renderer, scene, camera, controls, sea, buoy, paint }); // for the curious, and the test

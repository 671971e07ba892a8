// What an object is seen in: light, ground, and materials as the metallic and roughness model has them.
import {
  Color, DirectionalLight, Mesh, MeshPhysicalMaterial, MeshStandardMaterial, NeutralToneMapping, VSMShadowMap, PlaneGeometry,
  PMREMGenerator, Scene, ShadowMaterial, WebGLRenderer,
} from "three";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";

const dark = matchMedia("(prefers-color-scheme: dark)");

// Throws where there is no WebGL.
export function makeRenderer() {
  const renderer = new WebGLRenderer({ antialias: true });
  renderer.toneMapping = NeutralToneMapping; // keeps colours as they are up to near white
  renderer.transmissionResolutionScale = 0.5; // what is seen through glass
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = VSMShadowMap;
  return renderer;
}

// A room of soft light with a lamp above, and a ground that shows shadows alone. z is up.
export class Stage {
  constructor() {
    this.scene = new Scene();
    this.scene.environmentRotation.set(Math.PI / 2, 0, 0); // the room's y is up
    this.scene.backgroundRotation.copy(this.scene.environmentRotation);
    this.scene.environmentIntensity = 0.55;
    this.scene.backgroundBlurriness = 0.7;
    this.lamp = new DirectionalLight(0xffffff, 1.3);
    this.lamp.castShadow = true;
    this.lamp.shadow.mapSize.set(512, 512);
    this.lamp.shadow.radius = 6;
    this.lamp.shadow.blurSamples = 8;
    this.ground = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial());
    this.ground.receiveShadow = true;
    this.scene.add(this.lamp, this.lamp.target, this.ground);
    this.paint();
  }

  // The room's light, made by the renderer that draws with it.
  furnish(renderer) {
    const generator = new PMREMGenerator(renderer);
    const room = new RoomEnvironment();
    this.scene.environment = this.scene.background = generator.fromScene(room, 0.04).texture;
    room.dispose();
    generator.dispose();
  }

  paint() {
    this.scene.backgroundIntensity = dark.matches ? 0.15 : 1.7;
    this.ground.material.opacity = dark.matches ? 0.6 : 0.3;
  }

  whenRepainted(render) {
    dark.addEventListener("change", () => {
      this.paint();
      render();
    });
  }

  // Under an object and around it. centre: Vector3, [m].
  fit(centre, radius, lowest) {
    this.ground.scale.setScalar(40 * radius);
    this.ground.position.set(centre.x, centre.y, lowest - 0.01 * radius);
    this.lamp.target.position.copy(centre);
    this.lamp.position.set(-3.2, -1.2, 5.2).multiplyScalar(0.7 * radius).add(centre);
    const { camera } = this.lamp.shadow;
    camera.left = camera.bottom = -1.8 * radius;
    camera.right = camera.top = 1.8 * radius;
    camera.near = 0.5 * radius;
    camera.far = 9 * radius;
    camera.updateProjectionMatrix();
    this.lamp.shadow.normalBias = 0.015 * radius;
  }
}

// Of one part. hasColours: its vertices have some of their own. thickness [m]: of what light goes through in glass.
export function materialOf({ color, roughness, metallic, transmission }, hasColours, thickness) {
  const look = { roughness, metalness: metallic, vertexColors: hasColours };
  look.color = hasColours ? new Color(1, 1, 1) : new Color().setRGB(...color);
  if (transmission === 0) return new MeshStandardMaterial(look);
  return new MeshPhysicalMaterial({ ...look, transmission, ior: 1.5, thickness });
}

// Of an object whose vertices are coloured by a mode.
export function modeMaterial() {
  return new MeshStandardMaterial({ vertexColors: true, roughness: 0.6, metalness: 0 });
}

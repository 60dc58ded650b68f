// The page of `uwsim map view`: the occupied voxels of a map in 3D, coloured by height.
import { Decoder } from './vendor/cbor.js';
import { byId, grouped, write } from './dom.js';
import { MapView } from './map3d/map_view.js';
import './theme.js';

async function load(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(`${path}: ${answer.status} ${answer.statusText}`);
  return answer;
}

async function begin() {
  const about = await (await load('map/map.json')).json();
  write(byId('name'), about.name);
  document.title = about.name;
  const view = new MapView(about);
  byId('view').append(...view.element);
  view.look('south');
  const bytes = new Uint8Array(await (await load('map/voxels.cbor')).arrayBuffer());
  view.showMap(new Decoder({ mapsAsObjects: true }).decode(bytes));
  const size = about.high_m.map((high, k) => Number((high - about.low_m[k]).toPrecision(3))).join(' × ');
  const isWhole = about.cube_m === about.voxel_m;
  write(
    byId('about'),
    `${grouped(about.occupied)} voxels of ${about.voxel_m} m · ${size} m${isWhole ? '' : ` · shown in cubes of ${about.cube_m} m`}`,
  );
  Object.assign(globalThis, { mapView: view }); // for the browser's console and tests
}

begin().catch((error) => write(byId('about'), `Not shown: ${error.message}`));

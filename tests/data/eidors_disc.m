% Voltages of EIDORS's circular model with 16 point electrodes, adjacent drive and measurement, on two
% meshes: uniform, and with one disc of radius 0.2 and conductivity 0.5 at (0.3, 0.2). Writes
% eidors_disc.json. EIDORS 3.10+ as eidors3d/eidors-readonly on GitHub has it, commit 92270c1.
% Run: EIDORS=.../eidors/eidors octave-cli --no-gui -q eidors_disc.m
% EIDORS names objects by a compiled function, which is not there without a compiler: the folder in
% SHIM holds an eidors_var_id.m that gives every object a new name.
warning('off', 'all');
home = [getenv('EIDORS') '/'];
for folder = {'', 'algorithms', 'interface', 'models', 'meshing', 'solvers', 'tools', 'overloads', ...
              'graphics/matlab', 'solvers/forward', 'solvers/inverse', 'meshing/netgen', ...
              'overloads/octave', 'deprecated', 'examples', 'external'}
  if exist([home folder{1}], 'dir'); addpath([home folder{1}]); end
end
addpath(getenv('SHIM'));
global eidors_objects;
eidors_objects = struct('max_cache_size', 1e9, 'log_level', 0, 'cache_size', 1e9, 'cache_priority', 0);
eidors_objects.debug_enabled_on = {};
eidors_default('set', 'fwd_solve', 'fwd_solve_1st_order');
eidors_default('set', 'calc_system_mat', 'system_mat_1st_order');
out = fopen('eidors_disc.json', 'w');
fprintf(out, '{"centre":[0.3,0.2],"radius":0.2,"ratio":0.5,"current":10,"background":1');
meshes = {'f2c', 'j2c'};
for i = 1:2
  imdl = mk_common_model(meshes{i}, 16);
  fmdl = imdl.fwd_model;
  nodes = zeros(16, 2);
  for e = 1:16; nodes(e, :) = fmdl.nodes(fmdl.electrode(e).nodes(1), :); end
  % The part of an element in the disc, by 15 x 15 points of it.
  [a, b] = meshgrid(((1:15) - 0.5) / 15); flip = a + b > 1;
  a(flip) = 1 - a(flip); b(flip) = 1 - b(flip);
  corner = @(k) fmdl.nodes(fmdl.elems(:, k), :);
  share = zeros(size(fmdl.elems, 1), 1);
  for p = 1:numel(a)
    at = corner(1) + a(p) * (corner(2) - corner(1)) + b(p) * (corner(3) - corner(1));
    share = share + ((at(:, 1) - 0.3).^2 + (at(:, 2) - 0.2).^2 < 0.04) / numel(a);
  end
  img = mk_image(fmdl, 1);
  uniform = fwd_solve(img);
  img.elem_data = 1 - 0.5 * share;
  touched = fwd_solve(img);
  stim = full(fmdl.stimulation(1).stim_pattern);
  list = @(x) strjoin(arrayfun(@(v) sprintf('%.12g', v), x(:)', 'UniformOutput', false), ',');
  fprintf(out, ',"%s":{"elements":%d,"current_of_first_drive":[%s],"electrodes":[%s],"reference":[%s],"inclusion":[%s]}', ...
          meshes{i}, size(fmdl.elems, 1), list(stim), list(nodes'), list(uniform.meas), list(touched.meas));
end
fprintf(out, '}\n');
fclose(out);

% EIDORS as a command: its one-step Gauss-Newton and its total variation on the sheet of the
% experiment, in Octave.
%
%     {"type": "command", "command": ["octave-cli", "--norc", "--no-history", "--quiet",
%                                     "peers/eidors_child.m"],
%      "parameters": {"method": "one-step-gn", "prior": "noser"}}
%
% EIDORS itself is not here (get.sh says where it is); the environment variable EIDORS names the
% folder that holds its eidors_startup.m. The model is EIDORS's own d2s, whose sheet and electrodes the
% benchmark's defaults are; another sensor is refused.
%
% "method"   "one-step-gn": inv_solve_diff_GN_one_step, whose matrix is computed once (get_RM) and
%            applied by solve_use_matrix, as EIDORS advises for many frames; or
%            "total-variation": inv_solve_TV_pdipm.
% "prior"    of one-step-gn: "noser" (the default), "laplace" or "tikhonov".
% "hyperparameter"  > 0, or "auto" (the default): of a ladder of values the one of the least mean
%            relative error on the validation set ("frames" of it, 200 by default; of
%            total-variation 4, and a ladder of whole decades).
% "iterations"  of total-variation; default 10, as EIDORS has it.
1;

% fgetl looks for what comes behind the line, and waits for it.
function line = next_line()
  line = '';
  while true
    character = fread(stdin, 1, 'uint8=>char');
    if isempty(character) || character == "\n"
      return;
    end
    line(end + 1) = character;
  end
end

function answer(line)
  fputs(stdout, [jsonencode(line) "\n"]);
  fflush(stdout);
end

function refuse(why)
  answer(struct('error', why));
  exit(1);
end

function use_eidors(home, here)
  if isempty(home) || ! exist([home '/eidors_obj.m'], 'file')
    refuse('there is no EIDORS in $EIDORS: examples/peers/get.sh says where it is');
  end
  % As eidors_startup has it, but that nothing is compiled and nothing is written into its folder.
  folders = {'', '/solvers', '/solvers/inverse', '/solvers/forward', '/algorithms', '/interface', ...
             '/models', '/meshing', '/meshing/netgen', '/tools', '/graphics/matlab', ...
             '/deprecated', '/overloads'};
  warning('off', 'all');
  addpath([here '/eidors_without_mex']);
  for i = 1:numel(folders)
    addpath([home folders{i}]);
  end
  global eidors_objects;
  eidors_obj('eidors_version');
  eidors_cache('init');
  eidors_objects.log_level = 0;
  eidors_objects.log_level_custom = [];
  eidors_default('set', 'fwd_solve', 'fwd_solve_1st_order');
  eidors_default('set', 'calc_system_mat', 'system_mat_1st_order');
  eidors_default('set', 'calc_jacobian', 'jacobian_adjoint');
  eidors_default('set', 'inv_solve', 'inv_solve_diff_GN_one_step');
  eidors_default('set', 'calc_RtR_prior', 'prior_laplace');
  eidors_default('set', 'calc_R_prior', 'prior_laplace');
  eidors_default('set', 'mdl_normalize', @(x) 0);
  calc_colours('defaults');
  eidors_cache('cache_size', 1024^3);
  eidors_cache('boost_priority', 0);
end

function value = value_or(object, name, fallback)
  value = fallback;
  if isfield(object, name)
    value = object.(name);
  end
end

% [unknowns, frames] -> [pixels, frames], row 0 at y = -1. The unknowns of d2s are its pixels, two
% triangles each, in an order of EIDORS's.
function images = pixels_of(values, fmdl, side)
  centres = zeros(rows(fmdl.elems), 2);
  for corner = 1:3
    centres = centres + fmdl.nodes(fmdl.elems(:, corner), :) / 3;
  end
  if isfield(fmdl, 'coarse2fine')
    centres = (fmdl.coarse2fine' * centres) ./ full(sum(fmdl.coarse2fine, 1))';
  end
  place = floor((centres + 1) * side / 2);
  pixel = 1 + place(:, 1) + side * place(:, 2);
  images = zeros(side * side, columns(values));
  weight = accumarray(pixel, 1, [side * side 1]);
  for frame = 1:columns(values)
    images(:, frame) = accumarray(pixel, values(:, frame), [side * side 1]) ./ weight;
  end
end

function images = images_of(imdl, reference, changes, side)
  % inv_solve_TV_pdipm linearises at the conductivity 1, whatever the model says: it gets its voltages
  % and gives its images in units in which that is the background.
  unit = 1;
  if isequal(imdl.solve, @inv_solve_TV_pdipm)
    unit = imdl.jacobian_bkgnd.value;
  end
  img = inv_solve(imdl, unit * reference, unit * (reference + changes));
  images = unit * pixels_of(img.elem_data, imdl.fwd_model, side);
end

function imdl = with_value(imdl, method, value)
  imdl.hyperparameter.value = value;
  if strcmp(method, 'one-step-gn')
    imdl.solve_use_matrix.RM = get_RM(imdl);
    imdl.solve = @solve_use_matrix;
  end
end

told = jsondecode(next_line());
given = told.parameters;
side = told.image(1);
method = value_or(given, 'method', 'one-step-gn');
prior = value_or(given, 'prior', 'noser');
chosen = value_or(given, 'hyperparameter', 'auto');
if ! any(strcmp(method, {'one-step-gn', 'total-variation'}))
  refuse('"method" must be "one-step-gn" or "total-variation"');
end
if side != 24 || told.sensor.electrode_count != 16 || told.sensor.electrode_offset != 0.25
  refuse('EIDORS''s d2s has an image of 24 x 24 and 16 electrodes; this sensor is another');
end
use_eidors(getenv('EIDORS'), fileparts(mfilename('fullpath')));

imdl = mk_common_model('d2s', 16);
[stimulation, selected] = ...
    mk_stim_patterns(16, 1, [0 1], [0 1], {'no_meas_current'}, told.sensor.drive_current);
imdl.fwd_model.stimulation = stimulation;
imdl.fwd_model.meas_select = selected;
imdl.reconst_type = 'difference';
imdl.jacobian_bkgnd.value = told.background;
simulated = fwd_solve(mk_image(imdl.fwd_model, told.background));
reference = told.reference_voltages(:);
if norm(simulated.meas - reference) > 0.01 * norm(reference)
  fputs(stderr, "the reference voltages are not those of d2s\n");
end
used = struct('method', method);
if strcmp(method, 'one-step-gn')
  imdl.solve = @inv_solve_diff_GN_one_step;
  imdl.RtR_prior = str2func(['prior_' prior]);
  used.prior = prior;
  ladder = 10 .^ (-6:0.25:2);
  frames = value_or(given, 'frames', 200);
else
  imdl.solve = @inv_solve_TV_pdipm;
  imdl.fwd_model = rmfield(imdl.fwd_model, 'coarse2fine');  % its edges are those of the triangles
  imdl.R_prior = @prior_TV;
  imdl.parameters.max_iterations = value_or(given, 'iterations', 10);
  used.iterations = imdl.parameters.max_iterations;
  ladder = 10 .^ (-9:1:-5);
  frames = value_or(given, 'frames', 4);
end
if ischar(chosen)
  if isempty(told.validation)
    refuse('its hyperparameter is chosen on the validation set; add /datasets/validation');
  end
  % By name: Octave cannot read all that is in the file.
  set = load('-hdf5', told.validation, 'voltages', 'reference_voltages', 'conductivity');
  frames = min(frames, columns(set.voltages));
  changes = set.voltages(:, 1:frames) - set.reference_voltages(:);
  truths = reshape(set.conductivity, side * side, [])(:, 1:frames) - told.background;
  shown = norm(truths, 'columns') > 0;
  least = Inf;
  for value = ladder
    images = images_of(with_value(imdl, method, value), reference, changes(:, shown), side);
    wrong = mean(norm(images - truths(:, shown), 'columns') ./ norm(truths(:, shown), 'columns'));
    if wrong < least
      least = wrong;
      chosen = value;
    end
  end
end
used.hyperparameter = chosen;
imdl = with_value(imdl, method, chosen);
images_of(imdl, reference, zeros(told.channels, 1), side);
answer(struct('ready', true, 'parameters', used));

while true
  n = fread(stdin, 1, 'uint64');
  if isempty(n)
    break;
  end
  changes = fread(stdin, [told.channels n], 'double', 0, 'ieee-le');
  images = images_of(imdl, reference, changes, side);
  status = 2 * any(! isfinite(images), 1);
  fwrite(stdout, images, 'double', 0, 'ieee-le');
  fwrite(stdout, status, 'uint8');
  fflush(stdout);
end

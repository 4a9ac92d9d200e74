// How long the GPU takes for a picture, where the browser tells (EXT_disjoint_timer_query_webgl2).

export class GpuTime {
  /** @param {WebGL2RenderingContext} gl */
  constructor(gl) {
    this.gl = gl;
    this.extension = gl.getExtension('EXT_disjoint_timer_query_webgl2');
    this.asked = null; // a query whose answer is awaited
    this.open = false;
    this.ms = 0; // of the last picture that is known
  }

  /** Whether it is known at all. */
  get known() {
    return this.extension !== null;
  }

  begin() {
    const { gl, extension } = this;
    if (!extension) return;
    if (this.asked) {
      if (!gl.getQueryParameter(this.asked, gl.QUERY_RESULT_AVAILABLE)) return;
      if (!gl.getParameter(extension.GPU_DISJOINT_EXT)) this.ms = gl.getQueryParameter(this.asked, gl.QUERY_RESULT) / 1e6;
      gl.deleteQuery(this.asked);
    }
    this.asked = gl.createQuery();
    gl.beginQuery(extension.TIME_ELAPSED_EXT, this.asked);
    this.open = true;
  }

  end() {
    if (this.open) this.gl.endQuery(this.extension.TIME_ELAPSED_EXT);
    this.open = false;
  }
}
